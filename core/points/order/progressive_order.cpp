// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/points/order/progressive_order.h"

#include <algorithm>
#include <cassert>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <span>
#include <stop_token>
#include <utility>
#include <vector>

#include "core/ccdt/globe/chart.h"
#include "core/ccdt/polish/cell_list.h"
#include "core/geometry/axes.h"
#include "core/geometry/point3.h"
#include "core/points/order/elimination.h"
#include "core/points/order/spacing_meter.h"

namespace ccdt {

namespace {

using ordering::Elimination;
using ordering::kStopStride;
using ordering::PointBox;
using ordering::Points;
using ordering::Regions;
using ordering::SpacingMeter;

/// Returns the spacing around each point.
/// @param even     whether all spacings are equal
/// @param uniform  whether the density is uniform, so that only borders change the spacing. Except in a solid domain,
///                 measured spacings then count only if they exceed the usual one by a tenth, because smaller
///                 differences are due to chance. In a solid domain, they are 0.94 to 0.97 times the usual one on
///                 average, far from the border, because 12 neighbours form a complete shell
template <class P>
std::vector<double> spacings_of(const PointBox<P>& frame, const Points<P>& points, bool even, bool uniform,
                                Executor& executor, const std::stop_token& stop) {
    constexpr double kByChance = 1.1;
    const double usual = frame.usual_spacing(points.size());
    std::vector<double> spacings(points.size(), usual);
    if (even) return spacings;
    const BasicCellList<P> near = frame.cells(points.positions);
    for_ranges(executor, points.size(), kStopStride, [&](std::size_t begin, std::size_t end) {
        if (stop.stop_requested()) return;
        SpacingMeter<P> meter(frame, points, near, usual);
        for (auto i = static_cast<std::uint32_t>(begin); i < end; ++i) {
            const double measured = meter(i);
            if (!uniform || frame.is_solid || measured > kByChance * usual) spacings[i] = measured;
        }
    });
    return spacings;
}

/// Clamps a coordinate, so that points opposite the chart's centre are not at infinity.
double clamped(double coordinate) {
    constexpr double kMaxCoordinate = 1'000;  // a circle of 13 km around the opposite point
    return std::clamp(coordinate, -kMaxCoordinate, kMaxCoordinate);
}

/// Length of a vector added to the sum of the points' directions, so that points all over the globe do not cancel out.
constexpr double kTilt = 1e-6;

/// Least side of the box around points, which is needed if they coincide or lie on a line or in a plane.
constexpr double kMinSide = 1e-9;

/// Compares coordinates along the axes, one after the other.
template <class P>
std::strong_ordering compare(const P& p, const P& q) {
    for (std::size_t axis = 0; axis < kAxes<P>; ++axis) {
        if (along(p, axis) != along(q, axis))
            return along(p, axis) < along(q, axis) ? std::strong_ordering::less : std::strong_ordering::greater;
    }
    return std::strong_ordering::equal;
}

/// Returns the numbers of points that coincide, as lists in ascending order; empty if no points do. Points on a surface
/// coincide only if their normals are equal.
template <class P>
std::vector<std::vector<std::uint32_t>> coincident(const Points<P>& points) {
    const auto compared = [&](std::uint32_t i, std::uint32_t j) {
        const auto order = compare(points.positions[i], points.positions[j]);
        return order != 0 || points.normals.empty() ? order : compare(points.normals[i], points.normals[j]);
    };
    std::vector<std::uint32_t> numbers(points.size());
    std::iota(numbers.begin(), numbers.end(), 0U);
    std::ranges::sort(numbers, [&](std::uint32_t i, std::uint32_t j) {
        const auto order = compared(i, j);
        return order == 0 ? i < j : order < 0;
    });
    const auto are_equal = [&](std::uint32_t i, std::uint32_t j) { return compared(i, j) == 0; };
    if (std::ranges::adjacent_find(numbers, are_equal) == numbers.end()) return {};
    std::vector<std::vector<std::uint32_t>> groups;
    for (std::size_t i = 0; i < numbers.size(); ++i) {
        if (i == 0 || !are_equal(numbers[i], numbers[i - 1])) groups.emplace_back();
        groups.back().push_back(numbers[i]);
    }
    std::ranges::sort(groups);
    return groups;
}

/// Orders points of a frame progressively.
template <class P>
std::vector<std::uint32_t> order_distinct(const PointBox<P>& frame, const Points<P>& unsorted, bool even, bool uniform,
                                          const std::stop_token& stop, Executor& executor) {
    std::vector<std::uint32_t> order;
    std::vector<std::uint32_t> numbers(unsorted.size());
    std::iota(numbers.begin(), numbers.end(), 0U);
    Regions regions(std::span<const P>(unsorted.positions), numbers);
    Points<P> points = unsorted.selected(numbers);
    std::vector<double> spacings = spacings_of(frame, points, even, uniform, executor, stop);

    Elimination<P> elimination(frame, std::move(points), std::move(spacings), even, uniform, std::move(regions),
                               executor);
    while (elimination.remaining().size() > 1 && !stop.stop_requested()) {
        const std::vector<std::uint32_t> removed = elimination.step(stop);
        order.insert(order.end(), removed.begin(), removed.end());
    }
    order.insert(order.end(), elimination.remaining().begin(), elimination.remaining().end());
    std::ranges::reverse(order);
    for (std::uint32_t& each : order) each = numbers[each];
    return order;
}

/// Orders points of a frame progressively. Of points that coincide, one is ordered with the others, and the second,
/// third and further ones follow after all others.
template <class P>
std::vector<std::uint32_t> order_points(const PointBox<P>& frame, const Points<P>& points, bool even, bool uniform,
                                        const std::stop_token& stop, Executor& executor) {
    if (points.size() == 0) return {};
    const auto groups = coincident(points);
    if (groups.empty()) return order_distinct(frame, points, even, uniform, stop, executor);
    std::vector<std::uint32_t> firsts, order;
    for (const auto& group : groups) firsts.push_back(group.front());
    std::vector<std::uint32_t> remaining =
        order_distinct(frame, points.selected(firsts), even, uniform, stop, executor);
    for (std::size_t copy = 0; !remaining.empty(); ++copy) {
        for (const std::uint32_t each : remaining) order.push_back(groups[each][copy]);
        std::erase_if(remaining, [&](std::uint32_t each) { return groups[each].size() == copy + 1; });
    }
    return order;
}

std::vector<std::uint32_t> order_positions(const Domain& domain, std::vector<Point> positions, bool uniform,
                                           const std::stop_token& stop, Executor& executor) {
    const PointBox<Point> frame{domain.unit_bounds().max, domain.unit_area(), domain.is_torus(), false, &domain};
    return order_points<Point>(frame, {std::move(positions), {}}, uniform && domain.is_torus(), uniform, stop,
                               executor);
}

}  // namespace

std::vector<std::uint32_t> progressive_order(const Domain& domain, std::span<const Point> points, bool uniform,
                                             const std::stop_token& stop, Executor& executor) {
    std::vector<Point> positions;
    positions.reserve(points.size());
    for (const Point p : points) positions.push_back(domain.to_unit(p));
    return order_positions(domain, std::move(positions), uniform, stop, executor);
}

std::vector<std::uint32_t> progressive_order_on_globe(std::span<const Point> points, const std::stop_token& stop,
                                                      Executor& executor) {
    if (points.empty()) return {};
    std::vector<Direction> directions;
    directions.reserve(points.size());
    Direction sum{0, 0, kTilt};
    for (const Point p : points) {
        directions.push_back(direction_of(p));
        sum = sum + directions.back();
    }
    const Chart chart(normalised(sum));
    std::vector<Point> positions;
    positions.reserve(points.size());
    for (const Direction d : directions) {
        const Point p = chart.to_plane(d);
        positions.push_back({clamped(p.x), clamped(p.y)});
    }
    Box box{positions.front(), positions.front()};
    for (const Point p : positions) box.include(p);
    const double side = std::max({box.width(), box.height(), kMinSide});
    const Domain square = Domain::rectangle(side, side).value();
    for (Point& p : positions) p = square.to_unit(p - box.min);
    return order_positions(square, std::move(positions), false, stop, executor);
}

std::vector<std::uint32_t> progressive_order_on_surface(std::span<const Point3> points, std::span<const Point3> normals,
                                                        double area, bool uniform, bool closed,
                                                        const std::stop_token& stop, Executor& executor) {
    assert(normals.size() == points.size());
    if (points.empty()) return {};
    const Box3 box = bounds_of(points);
    const Point3 sides = box.max - box.min;
    const PointBox<Point3> frame{
        {std::max(sides.x, kMinSide), std::max(sides.y, kMinSide), std::max(sides.z, kMinSide)}, area};
    Points<Point3> moved{{}, {normals.begin(), normals.end()}};
    moved.positions.reserve(points.size());
    for (const Point3 p : points) moved.positions.push_back(p - box.min);
    return order_points(frame, moved, uniform && closed, uniform, stop, executor);
}

std::vector<std::uint32_t> progressive_order_in_space(const Box3& box, bool is_torus, std::span<const Point3> points,
                                                      double share, bool uniform, const std::stop_token& stop,
                                                      Executor& executor) {
    const Point3 sides = box.max - box.min;
    const double scale = std::max({sides.x, sides.y, sides.z});
    const Point3 unit{sides.x / scale, sides.y / scale, sides.z / scale};
    const PointBox<Point3> frame{unit, share * unit.x * unit.y * unit.z, is_torus, true};
    Points<Point3> moved;
    for (const Point3 p : points) {
        const Point3 q = p - box.min;
        moved.positions.push_back({q.x / scale, q.y / scale, q.z / scale});
    }
    return order_points(frame, moved, uniform && is_torus, uniform, stop, executor);
}

}  // namespace ccdt