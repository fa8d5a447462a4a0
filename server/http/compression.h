#pragma once

#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>

namespace ccdt::server {

/// Text. Pictures are compressed already.
bool is_compressible(std::string_view media_type);

/// Text of more than a kilobyte.
bool is_worth_compressing(std::string_view media_type, std::string_view body);

/// Whether an Accept-Encoding header wants gzip rather than nothing.
bool accepts_gzip(std::string_view accept_encoding);

/// Compressor of a text that comes in pieces.
class Gzip {
public:
    Gzip();
    ~Gzip();
    Gzip(const Gzip&) = delete;
    Gzip& operator=(const Gzip&) = delete;

    /// Compresses a piece.
    /// @param last    the text ends with it
    /// @param target  to which what is ready is appended
    void add(std::string_view piece, bool last, std::string& target);

private:
    struct Stream;
    const std::unique_ptr<Stream> stream_;
};

/// Compresses quickly rather than well: about 50 MB of JSON in a second, to less than a half.
/// @returns  none if it was stopped; asked after every 256 KiB
std::optional<std::string> gzip(std::string_view text, const std::stop_token& stop = {});

}  // namespace ccdt::server
