#pragma once

#include <memory>
#include <string>
#include <string_view>

#include <openssl/evp.h>

namespace ccdt::server {

/// SHA-256 of texts, each with its length, so that no two lists of them run together. Throws std::bad_alloc.
class Digest {
public:
    Digest();

    void add(std::string_view text);

    /// Finishes; to be called once.
    /// @returns  the beginning of the digest in base64, 24 characters: as many as nobody finds two lists of one digest
    ///           with
    std::string finish();

private:
    std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context_;
};

/// Signs a text by HMAC-SHA256 (RFC 2104). Throws std::bad_alloc.
/// @returns  the signature in URL-safe base64 without padding, 43 characters
std::string sign(std::string_view key, std::string_view text);

}  // namespace ccdt::server
