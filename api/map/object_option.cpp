// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/map/object_option.h"

#include <algorithm>
#include <string_view>
#include <utility>

namespace ccdt::api {

Result<std::string> take_object(std::vector<TextOption>& options) {
    constexpr std::string_view kName = "object";
    const auto find = [&] { return std::ranges::find(options, kName, &TextOption::name); };
    const auto found = find();
    if (found == options.end()) return std::string();
    std::string object = std::move(found->value);
    options.erase(found);
    if (find() != options.end()) return failure(ErrorCode::Malformed, "object is given twice", std::string(kName));
    return object;
}

}  // namespace ccdt::api
