// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/requests/digest.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <new>

#include <openssl/hmac.h>

namespace ccdt::server {
namespace {

constexpr int kBytesTold = 18;
constexpr int kSha256Bytes = 32;

}  // namespace

Digest::Digest() : context_(EVP_MD_CTX_new(), EVP_MD_CTX_free) {
    if (context_ == nullptr || EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr) != 1) throw std::bad_alloc();
}

void Digest::add(std::string_view text) {
    const std::uint64_t size = text.size();
    EVP_DigestUpdate(context_.get(), &size, sizeof(size));
    EVP_DigestUpdate(context_.get(), text.data(), text.size());
}

std::string Digest::finish() {
    std::array<unsigned char, EVP_MAX_MD_SIZE> bytes{};
    EVP_DigestFinal_ex(context_.get(), bytes.data(), nullptr);
    std::array<unsigned char, kBytesTold / 3 * 4 + 1> text{};
    EVP_EncodeBlock(text.data(), bytes.data(), kBytesTold);
    return {text.begin(), text.end() - 1};
}

std::string sign_in_base64(std::string_view key, std::string_view text) {
    std::array<unsigned char, kSha256Bytes> bytes{};
    const auto* const data = reinterpret_cast<const unsigned char*>(text.data());
    if (HMAC(EVP_sha256(), key.data(), static_cast<int>(key.size()), data, text.size(), bytes.data(), nullptr) ==
        nullptr)
        throw std::bad_alloc();
    std::array<unsigned char, (kSha256Bytes + 2) / 3 * 4 + 1> encoded{};
    EVP_EncodeBlock(encoded.data(), bytes.data(), kSha256Bytes);
    return {encoded.begin(), encoded.end() - 1};
}

std::string sign(std::string_view key, std::string_view text) {
    std::string signature = sign_in_base64(key, text);
    signature.pop_back();  // the padding
    std::ranges::replace(signature, '+', '-');
    std::ranges::replace(signature, '/', '_');
    return signature;
}

}  // namespace ccdt::server
