// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/volume/solid.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/base/elementary.h"
#include "core/ccdt/volume/point_text.h"
#include "core/geometry/axes.h"

namespace ccdt {

namespace {

constexpr double kMeasureCells = 1 << 18;  ///< cells by which the volume is measured
constexpr double kMinVolume = 1e-15;       ///< least volume of a solid, in the unit frame

/// Returns twice the area of a triangle projected along x; positive if its normal has the direction of x.
double projected_area(Point3 a, Point3 b, Point3 c) {
    return (b.y - a.y) * (c.z - a.z) - (b.z - a.z) * (c.y - a.y);
}

/// Returns the contribution of an edge to the winding number of a polygon around a point, in the projection along x: 1
/// or -1 if the edge crosses the line from the point along y, otherwise 0. The reversed edge contributes exactly the
/// opposite, so the sum over a closed surface is right in spite of rounding.
int edge_winding(Point3 from, Point3 to, Point3 p) {
    const bool up = from.z <= p.z;
    if (up == (to.z <= p.z)) return 0;
    const Point3 low = up ? from : to, high = up ? to : from;
    if (!(projected_area(low, high, p) > 0)) return 0;
    return up ? 1 : -1;
}

/// Returns the abscissa at which the line through p along x meets the plane of a triangle, within the triangle's
/// extent.
double crossing(const std::array<Point3, 3>& triangle, Point3 p) {
    const auto& [a, b, c] = triangle;
    const double u = projected_area(p, b, c), v = projected_area(p, c, a), w = projected_area(p, a, b);
    const double sum = u + v + w, x = sum != 0 ? (u * a.x + v * b.x + w * c.x) / sum : a.x;
    return std::clamp(x, std::min({a.x, b.x, c.x}), std::max({a.x, b.x, c.x}));
}

using Polygon3 = std::vector<Point3>;

/// Cuts a convex polygon by a plane perpendicular to an axis. Returns the parts in `below` and `above`.
void split(const Polygon3& polygon, std::size_t axis, double plane, Polygon3& below, Polygon3& above) {
    below.clear();
    above.clear();
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Point3 a = polygon[i], b = polygon[i + 1 < polygon.size() ? i + 1 : 0];
        const double from = along(a, axis) - plane, to = along(b, axis) - plane;
        if (from <= 0) below.push_back(a);
        if (from >= 0) above.push_back(a);
        if (from * to < 0) {
            Point3 middle = a + from / (from - to) * (b - a);
            along(middle, axis) = plane;
            below.push_back(middle);
            above.push_back(middle);
        }
    }
}

/// Calls visit(piece, cell) for the pieces of a convex polygon in the cells of a grid along an axis.
/// @param polygon  in units of cells; at least 3 points
template <class Visit>
void for_pieces(const Polygon3& polygon, std::size_t axis, std::size_t cells, Visit&& visit) {
    double low = along(polygon[0], axis), high = low;
    for (const Point3 p : polygon) {
        low = std::min(low, along(p, axis));
        high = std::max(high, along(p, axis));
    }
    const double end = static_cast<double>(cells) - 1;
    const auto first = static_cast<std::size_t>(std::clamp(std::floor(low), 0.0, end));
    const auto last = static_cast<std::size_t>(std::clamp(std::floor(high), 0.0, end));
    if (first == last) return visit(polygon, first);
    Polygon3 rest = polygon, piece, above;
    for (std::size_t cell = first; cell < last; ++cell) {
        split(rest, axis, static_cast<double>(cell + 1), piece, above);
        if (piece.size() > 2) visit(piece, cell);
        rest.swap(above);
    }
    if (rest.size() > 2) visit(rest, last);
}

}  // namespace

Result<Solid> Solid::create(Surface surface, const std::stop_token& stop) {
    for (std::uint32_t face = 0; face < surface.face_count() && !stop.stop_requested(); ++face) {
        const auto positions = surface.positions(face);
        for (std::uint32_t side = 0; side < 3; ++side) {
            if (surface.twin(4 * face + side) != Surface::kNone) continue;
            return failure(ErrorCode::Unusable, "the surface is open: only one triangle has the edge from " +
                                                    text(surface.to_input(positions[side])) + " to " +
                                                    text(surface.to_input(positions[(side + 1) % 3])));
        }
    }
    Solid solid(std::move(surface), stop);
    const Coverage coverage = solid.coverage(kMeasureCells, stop);
    if (stop.stop_requested()) return failure(ErrorCode::Stopped, "stopped before there was a result");
    const Point3 sides = solid.sides_;
    solid.volume_ = coverage.sum() / static_cast<double>(coverage.shares.size()) * (sides.x * sides.y * sides.z);
    if (!(solid.volume_ > kMinVolume) || !solid.find_interior())
        return failure(ErrorCode::Unusable, "the surface encloses no volume");
    return solid;
}

Solid::Solid(Surface surface, const std::stop_token& stop) : surface_(std::move(surface)) {
    Box3 box{surface_.vertex(0), surface_.vertex(0)};
    for (std::uint32_t v = 0; v < surface_.vertex_count(); ++v) {
        const Point3 p = surface_.vertex(v);
        box = bounds_of(std::array{box.min, box.max, p});
    }
    sides_ = box.max;
    bounds_ = {surface_.to_input(box.min), surface_.to_input(box.max)};
    orient_shells(stop);
}

double Solid::volume() const {
    const double scale = surface_.scale();
    return volume_ * scale * scale * scale;
}

void Solid::orient_shells(const std::stop_token& stop) {
    inverted_.assign(surface_.face_count(), false);
    std::vector<bool> visited(surface_.face_count(), false);
    std::vector<std::uint32_t> shell;
    for (std::uint32_t first = 0; first < surface_.face_count(); ++first) {
        if (visited[first]) continue;
        visited[first] = true;
        shell.assign(1, first);
        std::size_t turned = 0;
        // Unlike components, shells continue across creases.
        for (std::size_t i = 0; i < shell.size() && !stop.stop_requested(); ++i) {
            const std::uint32_t face = shell[i];
            turned += surface_.is_turned(face) ? 1 : 0;
            for (std::uint32_t side = 0; side < 3; ++side) {
                const std::uint32_t next = surface_.twin(4 * face + side) / 4;
                if (visited[next]) continue;
                visited[next] = true;
                shell.push_back(next);
            }
        }
        if (2 * turned <= shell.size()) continue;
        for (const std::uint32_t face : shell) inverted_[face] = true;
    }
}

/// Calls function(x, step) for each face that the half-line from p in the direction of x crosses, and for some behind
/// it. The winding number decreases by `step` where the half-line crosses the face at x.
template <class Function>
void Solid::for_crossings(Point3 p, Function&& function) const {
    surface_.tree().for_faces_on_ray(p, [&](std::uint32_t face) {
        const auto positions = surface_.positions(face);
        const auto& [a, b, c] = positions;
        const int turns = edge_winding(a, b, p) + edge_winding(b, c, p) + edge_winding(c, a, p);
        if (turns != 0) function(crossing(positions, p), inverted_[face] ? -turns : turns);
    });
}

bool Solid::holds(Point3 p) const {
    if (!(p.x >= 0 && p.y >= 0 && p.z >= 0 && p.x <= sides_.x && p.y <= sides_.y && p.z <= sides_.z)) return false;
    int winding = 0;
    for_crossings(p, [&](double x, int step) { winding += x > p.x ? step : 0; });
    return winding != 0;
}

/// Chooses the line along x through the middle of the face with the largest projection, and sets `interior_` to the
/// middle of the longest part of this line that is inside. Returns whether there is such a part.
bool Solid::find_interior() {
    Point3 middle;
    double widest = 0;
    for (std::uint32_t face = 0; face < surface_.face_count(); ++face) {
        const auto [a, b, c] = surface_.positions(face);
        const double width = std::abs(projected_area(a, b, c));
        if (width <= widest) continue;
        widest = width;
        middle = 1. / 3 * (a + b + c);
        middle.x = 0;  // on the left side of the solid, where the half-line must begin
    }
    std::vector<std::pair<double, int>> crossings;
    for_crossings(middle, [&](double x, int step) { crossings.emplace_back(x, step); });
    std::ranges::sort(crossings);
    double longest = 0;
    int winding = 0;
    for (std::size_t i = 1; i < crossings.size(); ++i) {
        winding -= crossings[i - 1].second;
        const double from = crossings[i - 1].first, to = crossings[i].first;
        if (winding == 0 || to - from <= longest) continue;
        longest = to - from;
        interior_ = {(from + to) / 2, middle.y, middle.z};
    }
    return longest > 0 && holds(interior_);
}

double Solid::Coverage::sum() const {
    return std::accumulate(shares.begin(), shares.end(), 0.0);
}

Solid::Coverage Solid::coverage(double count, const std::stop_token& stop) const {
    Coverage result;
    // A flat box has a single layer of cells, and a needle a single row.
    const double cell =
        std::max({elementary::cbrt(sides_.x * sides_.y * sides_.z / count), std::sqrt(sides_.x * sides_.y / count),
                  std::sqrt(sides_.y * sides_.z / count), std::sqrt(sides_.z * sides_.x / count), sides_.x / count,
                  sides_.y / count, sides_.z / count});
    Point3 per_length;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const double side = along(sides_, axis), cells = std::max(1.0, std::round(side / cell));
        result.cells[axis] = static_cast<std::size_t>(cells);
        along(per_length, axis) = side > 0 ? cells / side : 0;
    }
    const auto [columns, rows, layers] = result.cells;
    std::vector<double>& shares = result.shares;
    shares.assign(columns * rows * layers, 0);
    result.crossed.assign(shares.size(), false);
    Polygon3 polygon;
    for (std::uint32_t face = 0; face < surface_.face_count() && !stop.stop_requested(); ++face) {
        polygon.clear();
        for (const Point3 p : surface_.positions(face))
            polygon.push_back({p.x * per_length.x, p.y * per_length.y, p.z * per_length.z});
        const double sign = inverted_[face] ? -0.5 : 0.5;
        for_pieces(polygon, 2, layers, [&, rows = rows, columns = columns](const Polygon3& slice, std::size_t z) {
            for_pieces(slice, 1, rows, [&](const Polygon3& bar, std::size_t y) {
                for_pieces(bar, 0, columns, [&](const Polygon3& piece, std::size_t x) {
                    const std::size_t at = (z * rows + y) * columns + x;
                    result.crossed[at] = true;
                    for (std::size_t i = 2; i < piece.size(); ++i) {
                        const double area = sign * projected_area(piece[0], piece[i - 1], piece[i]);
                        const double within = (piece[0].x + piece[i - 1].x + piece[i].x) / 3 - static_cast<double>(x);
                        shares[at] += area * within;
                        if (x > 0) shares[at - 1] += area * (1 - within);
                    }
                });
            });
        });
    }
    // So far, each cell holds its mean winding number minus the mean winding number of the next cell along x. Sums give
    // the winding numbers.
    constexpr double kRounding = 1e-9;
    for (std::size_t line = 0; line < rows * layers; ++line) {
        double winding = 0;
        for (std::size_t x = columns; x-- > 0;) {
            double& share = shares[line * columns + x];
            winding += share;
            const double size = std::abs(winding);
            share = size < kRounding ? 0 : size > 1 - kRounding ? 1 : size;
        }
    }
    return result;
}

}  // namespace ccdt
