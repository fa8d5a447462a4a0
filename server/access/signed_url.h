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
/// `/halftone/cat.jpg?sites=500&expires=1800000000&signature=...`. Points into what it was parsed from.
///
/// The signature is the value of the last parameter. It is made by `sign` of all that stands before that parameter,
/// byte for byte as it is sent, percent-encoding included. Hence what is signed can be read in one way only.
struct SignedUrl {
    std::string_view text;                      ///< that the signature is of
    std::optional<std::string_view> signature;  ///< none: the last parameter is another one
    std::optional<std::uint64_t> expires;       ///< seconds since 1970 at which the URL stops being valid
    std::string options;                        ///< the query without both

    /// @param resource  path and query as sent
    /// Problems (400): several `expires`, or one that is no whole number.
    static HttpResult<SignedUrl> parse(std::string_view resource);

    /// Checks that a URL is signed and has not expired.
    /// @returns  the name of the key
    /// Problems (403): it is not signed, not by one of these keys, or has expired.
    HttpResult<std::string> check(const KeyRing& keys, std::chrono::sys_seconds now) const;
};

}  // namespace ccdt::server
