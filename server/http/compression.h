// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>

namespace ccdt::server {

/// Whether bodies of a media type may be compressed. True for texts except event streams.
bool is_compressible(std::string_view media_type);

/// Whether a body is text of more than a kilobyte.
bool is_worth_compressing(std::string_view media_type, std::string_view body);

/// Whether an Accept-Encoding header prefers gzip to no encoding.
bool accepts_gzip(std::string_view accept_encoding);

/// Compresses a text that arrives in pieces.
class Gzip {
public:
    Gzip();
    ~Gzip();
    Gzip(const Gzip&) = delete;
    Gzip& operator=(const Gzip&) = delete;

    /// Compresses a piece.
    /// @param last    whether the piece ends the text
    /// @param target  the compressed bytes that are available are appended to this string
    void add(std::string_view piece, bool last, std::string& target);

private:
    struct Stream;
    const std::unique_ptr<Stream> stream_;
};

/// Compresses a whole text fast: about 50 MB of JSON per second, to less than half of its size.
/// @param stop  checked every 256 KiB
/// @returns     none if a stop was requested
std::optional<std::string> gzip(std::string_view text, const std::stop_token& stop = {});

}  // namespace ccdt::server
