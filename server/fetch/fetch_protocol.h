// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace ccdt::server {

/// Message from the server to ccdt-fetcher, with a socket that is connected to the host of the URL. These programs are
/// built together, so the struct is sent as it is in memory.
struct FetchOrder {
    static constexpr std::size_t kMaxUrl = 1024;

    std::array<char, kMaxUrl + 1> url{};  ///< padded with zeros
    std::uint64_t max_bytes = 0;          ///< limit of the body
    std::int64_t timeout_ms = 0;          ///< limit of the whole exchange
};

/// Type of a message from ccdt-fetcher: its first byte. The other bytes are text.
enum class FetchNews : char {
    Size = 's',      ///< the size of the body, which follows; empty if the host does not state it
    Piece = 'p',     ///< the next piece of the body
    Done = 'd',      ///< the body is complete
    Redirect = 'r',  ///< the URL to which the host redirects
    TooLarge = 't',  ///< the body exceeds the limit
    Failed = 'f',    ///< the reason why there is no body
};

/// Maximum size of a message from ccdt-fetcher, in bytes. libcurl passes bodies in pieces of at most 16 KiB.
inline constexpr std::size_t kMaxFetchNews = 16'385;

}  // namespace ccdt::server
