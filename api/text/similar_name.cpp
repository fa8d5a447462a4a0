// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/text/similar_name.h"

#include <algorithm>
#include <numeric>
#include <utility>
#include <vector>

#include "api/text/text.h"

namespace ccdt::api {
namespace {

/// Returns the number of characters to insert, delete or replace so that one text becomes the other.
std::size_t edit_distance(std::string_view a, std::string_view b) {
    std::vector<std::size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), std::size_t{0});
    for (std::size_t i = 0; i < a.size(); ++i) {
        std::size_t diagonal = std::exchange(row[0], i + 1);
        for (std::size_t j = 0; j < b.size(); ++j) {
            const std::size_t replaced = diagonal + (a[i] == b[j] ? 0 : 1);
            diagonal = row[j + 1];
            row[j + 1] = std::min({replaced, row[j] + 1, diagonal + 1});
        }
    }
    return row.back();
}

}  // namespace

const std::string* find_similar(std::span<const std::string> names, std::string_view misspelt) {
    constexpr std::size_t kMaxDistance = 2, kMaxLength = 64;
    const std::string wanted = in_small_letters(misspelt.substr(0, kMaxLength));
    const std::string* nearest = nullptr;
    std::size_t least = kMaxDistance + 1;
    for (const std::string& name : names) {
        if (name.size() > kMaxLength) continue;
        const std::size_t distance = edit_distance(in_small_letters(name), wanted);
        if (distance < least) nearest = &name;
        least = std::min(distance, least);
    }
    return nearest;
}

}  // namespace ccdt::api
