// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/flags/flag_values.h"

#include "api/text/similar_name.h"
#include "api/text/text.h"

namespace ccdt::server {

Result<std::size_t> parse_whole(std::string_view text, std::uint64_t low, std::uint64_t high) {
    const auto number = api::parse_number<std::uint64_t>(text);
    if (!number || *number < low || *number > high)
        return failure(ErrorCode::Malformed,
                       "a whole number from " + std::to_string(low) + " to " + std::to_string(high));
    return static_cast<std::size_t>(*number);
}

Result<std::size_t> parse_bytes(std::string_view text, std::uint64_t low) {
    constexpr std::uint64_t kMax = std::uint64_t{1} << 40;
    int shift = 0;
    if (text.ends_with("KiB")) shift = 10;
    if (text.ends_with("MiB")) shift = 20;
    if (text.ends_with("GiB")) shift = 30;
    if (shift > 0) text.remove_suffix(3);
    const auto number = api::parse_number<std::uint64_t>(text);
    if (!number || *number < low || *number > (kMax >> shift))
        return failure(ErrorCode::Malformed, "a number of bytes, such as 67108864 or 64MiB");
    return static_cast<std::size_t>(*number << shift);
}

std::string format_bytes(std::size_t bytes) {
    constexpr std::size_t kStep = 1024, kTenths = 10;
    std::size_t unit = 1;
    std::string_view name;
    for (const std::string_view larger : {"KiB", "MiB", "GiB"}) {
        if (bytes / kStep < unit) break;
        unit *= kStep;
        name = larger;
    }
    const std::size_t rounded = bytes / unit * kTenths + (bytes % unit * kTenths + unit / 2) / unit;
    const std::string fraction = rounded % kTenths == 0 ? "" : '.' + std::to_string(rounded % kTenths);
    return std::to_string(rounded / kTenths) + fraction + std::string(name);
}

std::string suggestion(std::span<const std::string> names, std::string_view misspelt) {
    const std::string* const similar = api::find_similar(names, misspelt);
    return similar == nullptr ? "--help lists the options" : "did you mean " + *similar + "?";
}

}  // namespace ccdt::server
