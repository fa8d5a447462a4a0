// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "api/input/feature_list.h"
#include "api/input/palette.h"
#include "api/output/ink_dots.h"

namespace ccdt::api {

/// Calls function(feature, first, count) for each run of points of the same feature.
/// @param features  [points] feature of each point
template <class Function>
void for_features(std::span<const std::uint32_t> features, Function&& function) {
    for (std::size_t first = 0; first < features.size();) {
        std::size_t end = first + 1;
        while (end < features.size() && features[end] == features[first]) ++end;
        function(features[first], first, end - first);
        first = end;
    }
}

struct MapFigure;

/// Zooms of vector tiles.
struct DotTiles {
    static constexpr int kMaxZoom = 22;
    static constexpr std::size_t kMaxDots = 50'000;

    int min_zoom = 0;
    std::optional<int> max_zoom = {};  ///< none: the first zoom at which no tile has more than `dots_per_tile` dots
    std::size_t dots_per_tile = 10'000;
};

/// Points of an answer, as writers receive them. Each ink and each class of a dot map is a layer.
/// All objects to which this object refers must outlive it.
struct PointSet {
    std::span<const InkDots> layers;  ///< at least one
    /// [features] Ids as JSON, empty for a feature without id. No elements: points are not grouped by features.
    std::span<const std::string> feature_ids = {};
    const CarriedProperties* properties = nullptr;  ///< properties of the features; null: points carry none
    std::optional<double> tone = {};                ///< DotSize::tone of a halftone, for descriptions of drawings
    DotTiles tiles = {};                            ///< zooms, for tiles
    const MapFigure* figure = nullptr;              ///< the rest of a drawing as a map; null: points only

    bool are_grouped() const { return !feature_ids.empty(); }

    /// Returns whether answers name the layers. A single layer may have no name; answers then contain only its points.
    bool are_named() const {
        return std::ranges::any_of(layers, [](const InkDots& each) { return !each.ink.name.empty(); });
    }
    bool are_ranked() const {
        return std::ranges::any_of(layers, [](const InkDots& each) { return !each.dots.ranks.empty(); });
    }
    bool are_partial() const {
        return std::ranges::any_of(layers, [](const InkDots& each) { return each.dots.stopped; });
    }
    std::size_t size() const {
        std::size_t points = 0;
        for (const InkDots& each : layers) points += each.dots.points.size();
        return points;
    }
    std::vector<Ink> inks() const {
        std::vector<Ink> copies;
        for (const InkDots& each : layers) copies.push_back(each.ink);
        return copies;
    }

    /// Calls function(feature, first, count) for each group of points in a layer. Without features, the whole layer is
    /// one group, with the feature 0.
    template <class Function>
    void for_groups(const InkDots& layer, Function&& function) const {
        if (!are_grouped()) return function(std::uint32_t{0}, std::size_t{0}, layer.dots.points.size());
        for_features(layer.features, function);
    }
};

}  // namespace ccdt::api
