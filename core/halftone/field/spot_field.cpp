// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/field/spot_field.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/delaunay.h"
#include "core/halftone/field/spot_function.h"
#include "core/picture/pixel_ranges.h"

namespace ccdt {

namespace {

using Corners = SpotTriangles::Corners;

/// Scaled length of the longer side of a picture.
constexpr double kSide = 0.3;

/// Returns a coordinate and those of its mirror images that are near the picture.
/// @param position  from the middle of a side
std::vector<double> images(double position, double side, double reach) {
    std::vector<double> positions{position};
    for (const double end : {-side / 2, side / 2}) {
        if (std::abs(end - position) <= reach * side) positions.push_back(2 * end - position);
    }
    return positions;
}

/// Returns the sites and their mirror images, with coordinates in which the longer side of the box is kSide and its
/// centre lies at (1/2, 1/2).
std::vector<Point> mirrored(std::span<const Point> sites, const Box& box) {
    // Triangles that reach into the picture have corners within this share of a side.
    constexpr std::size_t kFew = 1000;
    const double reach = sites.size() > kFew ? 0.15 : 1;
    const double scale = kSide / std::max(box.width(), box.height());
    std::vector<Point> points;
    for (const Point& site : sites) {
        const auto across = images(site.x - box.min.x - box.width() / 2, box.width(), reach);
        for (const double y : images(site.y - box.min.y - box.height() / 2, box.height(), reach)) {
            for (const double x : across) points.push_back({0.5 + scale * x, 0.5 + scale * y});
        }
    }
    return points;
}

/// Returns the first cell whose centre is not before a position.
int first_centre(double position) {
    constexpr double kMax = 1e9;
    return static_cast<int>(std::ceil(std::clamp(position, 0.0, kMax) - 0.5));
}

Corners in_cells(Corners corners, const CellGrid& cells) {
    for (Point& p : corners) p = {p.x * cells.columns, p.y * cells.rows};
    return corners;
}

/// An edge of a triangle, from its upper to its lower end. Triangles that share it compute the same positions on it.
struct Edge {
    Edge(Point upper, Point lower) : end(upper), slope((lower.x - upper.x) / (lower.y - upper.y)) {}
    double x(double y) const { return end.x + (y - end.y) * slope; }

    Point end;
    double slope;  ///< not finite if the edge is horizontal
};

/// Writes the spot function of a triangle to the centres of cells in the rows [first, end).
/// @param corners  in cells
void paint_triangle(const Corners& corners, const SpotFunction& spots, int first, int end, int columns, float* values) {
    const auto [a, b, c] = corners;
    const double twice = (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    if (!(twice > 0)) return;
    const Point second = {(c.y - a.y) / twice, (a.x - c.x) / twice}, third = {(a.y - b.y) / twice, (b.x - a.x) / twice};
    Corners downwards = corners;
    std::ranges::sort(downwards, {}, &Point::y);
    const auto [upper, middle, lower] = downwards;
    const Edge whole(upper, lower), before(upper, middle), after(middle, lower);
    const auto step_v = static_cast<float>(second.x), step_w = static_cast<float>(third.x);
    for (int row = std::max(first_centre(upper.y), first), last = std::min(first_centre(lower.y), end); row < last;
         ++row) {
        const double y = row + 0.5;
        const auto [left, right] = std::minmax({whole.x(y), (y < middle.y ? before : after).x(y)});
        const int begin = first_centre(left), stop = std::min(first_centre(right), columns);
        const Point p{begin + 0.5 - a.x, y - a.y};
        auto v = static_cast<float>(second.x * p.x + second.y * p.y);
        auto w = static_cast<float>(third.x * p.x + third.y * p.y);
        float* const out = values + static_cast<std::size_t>(row - first) * static_cast<std::size_t>(columns);
        for (int x = begin; x < stop; ++x, v += step_v, w += step_w) out[x] = spots(1 - v - w, v, w);
    }
}

}  // namespace

SpotTriangles::SpotTriangles(std::span<const Point> sites, const Box& box) {
    const auto mesh = constrained_delaunay(mirrored(sites, box), {});
    if (!mesh) return;
    const double longer = std::max(box.width(), box.height());
    const Point scale{longer / box.width() / kSide, longer / box.height() / kSide};
    for (const Point& p : mesh->points) points_.push_back({(p.x - 0.5) * scale.x + 0.5, (p.y - 0.5) * scale.y + 0.5});
    for (const auto& triangle : mesh->triangles) {
        auto& corners = triangles_.emplace_back();
        for (std::size_t i = 0; i < 3; ++i) corners[i] = static_cast<std::uint32_t>(triangle.corners[i]);
    }
}

Corners SpotTriangles::corners(std::size_t triangle) const {
    const auto [a, b, c] = triangles_[triangle];
    return {points_[a], points_[b], points_[c]};
}

SpotField::SpotField(const SpotTriangles& triangles, const CellGrid& cells)
    : triangles_(triangles), cells_(cells), bands_(static_cast<std::size_t>((cells.rows - 1) / kRowsOfBand + 1)) {
    for (std::uint32_t t = 0; t < triangles.count(); ++t) {
        const auto [a, b, c] = in_cells(triangles.corners(t), cells);
        const auto [low, high] = std::minmax({a.y, b.y, c.y});
        const int first = first_centre(low), end = std::min(first_centre(high), cells.rows);
        for (int row = first; row < end; row = (row / kRowsOfBand + 1) * kRowsOfBand)
            bands_[static_cast<std::size_t>(row / kRowsOfBand)].push_back(t);
    }
}

void SpotField::paint(int first, int end, std::span<float> values) const {
    static const SpotFunction kSpots;
    if (triangles_.count() == 0) std::ranges::fill(values, 0.5f);
    for (int band = first / kRowsOfBand; band * kRowsOfBand < end; ++band) {
        const int from = std::max(first, band * kRowsOfBand), to = std::min(end, (band + 1) * kRowsOfBand);
        float* const out =
            values.data() + static_cast<std::size_t>(from - first) * static_cast<std::size_t>(cells_.columns);
        for (const std::uint32_t t : bands_[static_cast<std::size_t>(band)])
            paint_triangle(in_cells(triangles_.corners(t), cells_), kSpots, from, to, cells_.columns, out);
    }
}

std::vector<float> SpotField::values(Executor& executor) const {
    const auto columns = static_cast<std::size_t>(cells_.columns);
    std::vector<float> all(columns * static_cast<std::size_t>(cells_.rows));
    executor.run(bands_.size(), [&](std::size_t band) {
        const int first = static_cast<int>(band) * kRowsOfBand, end = std::min(first + kRowsOfBand, cells_.rows);
        paint(first, end,
              std::span(all).subspan(static_cast<std::size_t>(first) * columns,
                                     static_cast<std::size_t>(end - first) * columns));
    });
    return all;
}

}  // namespace ccdt
