// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

namespace ccdt::api {

/// A part of a text.
struct TextRange {
    std::size_t begin = 0, end = 0;

    std::string_view in(std::string_view text) const { return text.substr(begin, end - begin); }
};

/// Places of the features in a text of GeoJSON.
struct FeatureTexts {
    std::vector<TextRange> features;
    /// The elements of the member `features`, without its brackets; none if the text is a sequence of objects, as in
    /// JsonDocument::parse_features().
    std::optional<TextRange> list;
};

/// Finds the features of GeoJSON without parsing them, so that they can be parsed one after the other, in little
/// memory. Returns none for text in which they cannot be found. The features, and the text without the list, may still
/// be invalid.
std::optional<FeatureTexts> find_features(std::string_view text);

}  // namespace ccdt::api
