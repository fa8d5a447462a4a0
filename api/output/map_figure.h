// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "api/input/colour.h"
#include "api/output/page.h"
#include "api/output/point_set.h"
#include "core/ccdt/maps/outlines.h"
#include "core/geometry/point.h"

namespace ccdt::api {

/// Line of a legend.
struct LegendEntry {
    std::optional<Colour> colour;  ///< of the disc before the text; none: there is no disc
    std::string text;              ///< UTF-8
    Point at;                      ///< left end of the baseline, in the units of the points
};

/// Outlines and legend of a map, without its dots. Lengths are in the units of the points.
struct MapFigure {
    std::function<void(const LineSink&)> outlines;  ///< traces the borders of the features; null: the map has none
    double line_width = 0;                          ///< of outlines
    std::vector<LegendEntry> legend;                ///< no elements: the map has no legend
    double text_size = 0;                           ///< of the legend
};

inline constexpr Colour kOutlineColour{170, 170, 170};

/// Radius of the discs of a legend, and the distance of their centres from the baseline, in sizes of its text.
inline constexpr double kSwatchRadius = 0.3, kSwatchHeight = 0.35;

/// Distance from the left end of an entry to its text, in sizes of the text.
inline constexpr double kLegendIndent = 1;

/// A dot of a map, in drawing order.
struct MixedDot {
    std::uint32_t feature;  ///< 0 if points are not grouped
    std::uint32_t layer;
    std::size_t point;  ///< index of the point in the layer
};

/// Returns all dots, grouped by feature. Within a group, the dots of the layers alternate in proportion to their
/// numbers, so that no layer covers the others. O(n log n).
std::vector<MixedDot> mixed_dots(const PointSet& points);

/// Draws a map with an object `medium`, as SvgMap in svg_map.cpp. Points are relative to the upper left corner.
/// @param unit  length on the page of one unit of the points
/// @param stop  once stopped, drawing ends early
template <class Medium>
void draw_map(const PointSet& points, const Page& page, double unit, Medium& medium, const std::stop_token& stop) {
    constexpr std::size_t kCheckInterval = 1'000;
    const MapFigure& figure = *points.figure;
    const PageMapping position(page, unit);
    if (figure.outlines) {
        medium.begin_lines(kOutlineColour, unit * figure.line_width);
        figure.outlines([&](Point corner, bool begins) {
            if (begins) {
                medium.begin_line(position(corner));
            } else {
                medium.line_to(position(corner));
            }
        });
        medium.end_lines();
    }
    std::optional<std::uint32_t> group;
    const std::vector<MixedDot> dots = mixed_dots(points);
    for (std::size_t i = 0; i < dots.size(); ++i) {
        if (i % kCheckInterval == 0 && (stop.stop_requested() || !medium.should_continue())) break;
        const auto& [feature, layer, point] = dots[i];
        if (points.are_grouped() && group != feature) {
            if (group) medium.end_group();
            medium.begin_group(*(group = feature));
        }
        const InkDots& own = points.layers[layer];
        medium.dot(position(own.dots.points[point]), unit * own.radius, layer,
                   own.dots.ranks.empty() ? std::nullopt : std::optional(own.dots.ranks[point]));
    }
    if (group) medium.end_group();
    if (figure.legend.empty()) return;
    const double size = unit * figure.text_size;
    medium.begin_legend();
    for (const LegendEntry& entry : figure.legend) {
        const Point at = position(entry.at);
        if (entry.colour)
            medium.swatch(at + size * Point{kSwatchRadius, -kSwatchHeight}, size * kSwatchRadius, *entry.colour);
        medium.text(at + Point{entry.colour ? kLegendIndent * size : 0, 0}, size, entry.text);
    }
    medium.end_legend();
}

}  // namespace ccdt::api
