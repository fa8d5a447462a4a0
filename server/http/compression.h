#pragma once

#include <optional>
#include <stop_token>
#include <string>
#include <string_view>

namespace ccdt::server {

/// Text of more than a kilobyte. Pictures are compressed already.
bool is_worth_compressing(std::string_view media_type, std::string_view body);

/// Whether an Accept-Encoding header wants gzip rather than nothing.
bool accepts_gzip(std::string_view accept_encoding);

/// Compresses quickly rather than well: about 50 MB of JSON in a second, to less than a half.
/// @returns  none if it was stopped; asked after every 256 KiB
std::optional<std::string> gzip(std::string_view text, const std::stop_token& stop = {});

}  // namespace ccdt::server
