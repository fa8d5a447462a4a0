// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "server/access/key_ring.h"
#include "server/http/problem.h"

namespace ccdt::server {

/// The path and query of a URL that may be signed, such as
/// `/halftone/cat.jpg?sites=500&expires=1800000000&signature=...`. The views point into the text that was parsed.
///
/// The signature is the value of the last parameter. sign() computes it from the text before that parameter, byte for
/// byte as sent. Percent-encoding is not decoded, so client and server sign the same text.
struct SignedUrl {
    std::string_view text;                      ///< the signed text
    std::optional<std::string_view> signature;  ///< none: the last parameter is not `signature`
    std::optional<std::uint64_t> expires;       ///< Unix time at which the URL becomes invalid [s]
    std::string options;                        ///< the query without `signature` and `expires`

    /// Parses a path and query as sent.
    /// Problems (400): several `expires`, or one that is not a whole number.
    static HttpResult<SignedUrl> parse(std::string_view resource);

    /// Checks that a URL is signed and has not expired.
    /// @returns  the name of the key that signed the URL
    /// Problems (403): the URL is not signed, not signed with one of these keys, or expired.
    HttpResult<std::string> check(const KeyRing& keys, std::chrono::sys_seconds now) const;
};

}  // namespace ccdt::server
