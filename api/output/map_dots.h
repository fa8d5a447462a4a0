// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "api/input/feature_list.h"
#include "api/input/palette.h"
#include "api/output/ink_dots.h"
#include "core/dotmap/dot_map.h"

namespace ccdt::api {

/// Dots of one class of a dot map, as writers receive them. All objects that this one refers to must outlive it.
struct MapDots {
    const Ink& ink;  ///< its name is that of the class; empty for a single class that answers do not name
    const ClassDots& dots;
    double radius = 0;  ///< radius of each dot, in the units of the points; used only by drawings
};

/// Dots of all classes of a dot map, and its features.
struct MapOfDots {
    std::span<const MapDots> classes;               ///< at least one
    std::span<const std::string> feature_ids;       ///< [features] as JSON; empty for a feature without id
    const CarriedProperties* properties = nullptr;  ///< properties of the features; null: points carry none

    bool are_named() const { return !classes.front().ink.name.empty(); }
    bool are_ranked() const {
        return std::ranges::any_of(classes, [](const MapDots& each) { return !each.dots.dots.ranks.empty(); });
    }
    std::size_t size() const {
        std::size_t points = 0;
        for (const MapDots& each : classes) points += each.dots.dots.points.size();
        return points;
    }
};

/// Calls function(feature, first, count) for each run of points of the same feature.
template <class Function>
void for_features(const ClassDots& dots, Function&& function) {
    const auto& features = dots.feature_of;
    for (std::size_t first = 0; first < features.size();) {
        std::size_t end = first + 1;
        while (end < features.size() && features[end] == features[first]) ++end;
        function(features[first], first, end - first);
        first = end;
    }
}

}  // namespace ccdt::api
