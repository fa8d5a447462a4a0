// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/http/byte_range.h"

#include <algorithm>
#include <limits>

#include "api/text/numbers.h"
#include "api/text/text.h"

namespace ccdt::server {

std::optional<ByteRange> parse_range(std::string_view range, std::size_t size) {
    constexpr std::string_view kUnit = "bytes=";
    if (!range.starts_with(kUnit) || range.find('-') == std::string_view::npos) return std::nullopt;
    range.remove_prefix(kUnit.size());
    const auto begin = api::trim(api::take_until(range, "-")), end = api::trim(range);
    const auto first = api::parse_number<std::size_t>(begin), last = api::parse_number<std::size_t>(end);
    if ((!first && !begin.empty()) || (!last && !end.empty()) || (!first && !last)) return std::nullopt;
    if (!first) {
        const std::size_t length = std::min(*last, size);
        return ByteRange{size - length, length};
    }
    if (last && *last < *first) return std::nullopt;
    if (*first >= size) return ByteRange{size, 0};
    return ByteRange{*first, std::min(last.value_or(size - 1), size - 1) - *first + 1};
}

}  // namespace ccdt::server
