// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include <openssl/evp.h>

namespace ccdt::server {

/// A SHA-256 digest of a list of texts. The length of each text is hashed, too, so that {"ab", "c"} and {"a", "bc"}
/// have different digests. Throws std::bad_alloc.
class Digest {
public:
    Digest();

    void add(std::string_view text);

    /// Finishes the digest. Must be called at most once.
    /// @returns  the first 18 bytes of the digest in base64 (24 characters), enough to make collisions infeasible
    std::string finish();

private:
    std::unique_ptr<EVP_MD_CTX, decltype(&EVP_MD_CTX_free)> context_;
};

/// Signs a text with HMAC-SHA256 (RFC 2104). Throws std::bad_alloc.
/// @returns  the signature in URL-safe base64 without padding, 43 characters
std::string sign(std::string_view key, std::string_view text);

/// Signs a text as sign() does.
/// @returns  the signature in base64 with padding, 44 characters
std::string sign_in_base64(std::string_view key, std::string_view text);

}  // namespace ccdt::server
