#include "server/work/digest.h"

#include <array>
#include <cstdint>
#include <new>

namespace ccdt::server {
namespace {

constexpr int kBytesTold = 18;

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

}  // namespace ccdt::server
