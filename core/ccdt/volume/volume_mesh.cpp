// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/volume/volume_mesh.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <optional>
#include <set>
#include <vector>

#include "core/ccdt/polish/cell_list.h"
#include "core/ccdt/volume/tetrahedron_quality.h"
#include "core/ccdt/volume/voxel_density.h"

namespace ccdt {

namespace {

constexpr double kNarrowest = 6;  ///< least side of a torus whose tetrahedra are improved, in spacings
constexpr double kRim = 2;        ///< width of the rim of periodic copies that are known at the start, in spacings

constexpr double kMaxRim = 8;  ///< greatest width of this rim, in shortest sides of the torus

/// Points on a torus and some of their periodic copies.
class PeriodicCopies {
public:
    /// Creates the points and the copies around the domain that usually suffice.
    PeriodicCopies(const BoxDomain3& domain, const VolumeSpacing& spacing, std::span<const Point3> points)
        : domain_(domain), points_(points), positions_(points.begin(), points.end()), numbers_(points.size()) {
        std::iota(numbers_.begin(), numbers_.end(), 0U);
        rims_.reserve(points.size());
        const double shortest = std::min({domain.sides.x, domain.sides.y, domain.sides.z});
        for (const Point3 p : points) {
            const double rim = std::min(kRim * spacing.side(p), kMaxRim * shortest);
            rims_.push_back(rim);
            known_ = std::min(known_, rim);
            const auto number = static_cast<std::uint32_t>(rims_.size() - 1);
            domain.for_copies(p, rim, [&](Point3 copy, bool is_original) {
                if (!is_original) add(number, copy);
            });
        }
        // Encloses all points, even if there are none near the border.
        if (!spacing.is_uniform()) {
            const Point3 p = points.front(), margin = 1.5 * domain.sides;
            domain.for_copies(p, Box3{p - margin, p + margin}, [&](Point3 copy, bool) { add_missing(0, copy); });
        }
    }

    std::span<const Point3> positions() const { return positions_; }

    /// Returns the number of the point of which a position is a copy.
    std::uint32_t number(std::uint32_t position) const { return numbers_[position]; }

    /// Adds the copy of a point that is nearest to the centre of a tetrahedron's circumsphere, if the copy lies in the
    /// sphere and is not known.
    /// @returns  whether a copy was added
    bool complete(const Tetrahedron& tetrahedron) {
        const auto sphere = circumsphere(tetrahedron);
        if (!sphere || is_known(*sphere)) return false;
        const Point3 centre = domain_.inside(sphere->centre);
        std::optional<std::uint32_t> nearest;
        Point3 offset;  ///< of the nearest copy from the centre
        double least = (1 - kRounding) * sphere->radius;
        for (double reach = least / kFirstSearch; !nearest; reach = std::min(2 * reach, least)) {
            list_.for_near(centre, reach, [&](Point3, std::uint32_t number) {
                const Point3 from = wrapped(points_[number] - centre);
                if (length(from) >= std::min(reach, least)) return;
                least = length(from);
                nearest = number;
                offset = from;
            });
            if (reach >= least) break;
        }
        return nearest && add_missing(*nearest, sphere->centre + offset);
    }

private:
    static constexpr double kRounding = 1e-7;   ///< relative error of computed spheres
    static constexpr double kFirstSearch = 32;  ///< radius of a sphere / radius of the first search in it

    struct Sphere {
        Point3 centre;
        double radius;
    };

    /// Returns the circumsphere of a tetrahedron. If it is wider than the torus, returns a smaller sphere within it
    /// that contains copies of all points. Returns none if the tetrahedron is flat.
    std::optional<Sphere> circumsphere(const Tetrahedron& tetrahedron) const {
        const Point3 a = positions_[tetrahedron[0]];
        const Point3 u = positions_[tetrahedron[1]] - a, v = positions_[tetrahedron[2]] - a,
                     w = positions_[tetrahedron[3]] - a;
        const Point3 top = dot(u, u) * cross(v, w) + dot(v, v) * cross(w, u) + dot(w, w) * cross(u, v);
        const Point3 to_centre = (1 / (2 * dot(u, cross(v, w)))) * top;
        const double radius = length(to_centre), widest = length(domain_.sides);
        if (!std::isfinite(radius)) return std::nullopt;
        if (radius > widest) return Sphere{a + (widest / radius) * to_centre, widest};
        const auto distance = [&](Point3 p) { return length(p - to_centre); };
        return Sphere{a + to_centre, std::min({radius, distance(u), distance(v), distance(w)})};
    }

    /// Whether all copies in a sphere are known. All copies are known in the domain and in a rim around it, so the
    /// sphere must lie there.
    bool is_known(const Sphere& sphere) const {
        const auto fits = [&](double centre, double side) {
            return centre - sphere.radius >= -known_ && centre + sphere.radius <= side + known_;
        };
        return fits(sphere.centre.x, domain_.sides.x) && fits(sphere.centre.y, domain_.sides.y) &&
               fits(sphere.centre.z, domain_.sides.z);
    }

    /// Returns the copy of an offset that is nearest to the origin.
    Point3 wrapped(Point3 offset) const { return offset - shift_of(offset); }

    /// Returns the multiples of the sides that are nearest to an offset.
    Point3 shift_of(Point3 offset) const {
        const auto& [x, y, z] = domain_.sides;
        return {x * std::round(offset.x / x), y * std::round(offset.y / y), z * std::round(offset.z / z)};
    }

    void add(std::uint32_t number, Point3 copy) {
        positions_.push_back(copy);
        numbers_.push_back(number);
    }

    /// Adds a copy of a point unless it is known.
    bool add_missing(std::uint32_t number, Point3 near) {
        const Point3 p = points_[number], shift = shift_of(near - p), copy = p + shift;
        const double rim = rims_[number];
        const auto is_in_rim = [rim](double v, double side) { return v >= -rim && v <= side + rim; };
        const auto& [x, y, z] = domain_.sides;
        if (is_in_rim(copy.x, x) && is_in_rim(copy.y, y) && is_in_rim(copy.z, z)) return false;
        if (!added_.insert({copy.x, copy.y, copy.z}).second) return false;
        add(number, copy);
        return true;
    }

    const BoxDomain3& domain_;
    const std::span<const Point3> points_;
    std::vector<Point3> positions_;  ///< the points, then copies
    std::vector<std::uint32_t> numbers_;
    std::vector<double> rims_;  ///< [points] distances from the domain up to which copies are known
    double known_ = std::numeric_limits<double>::max();  ///< the least of them
    std::set<std::array<double, 3>> added_;              ///< copies farther away
    const BasicCellList<Point3> list_{domain_.sides, points_};
};

/// Computes the triangulation of the points and some copies of them. While another copy lies in the circumsphere of a
/// tetrahedron, adds it and repeats. So the number of copies does not depend on the widest gap between points.
TetrahedronMesh torus_mesh(const BoxDomain3& domain, const VolumeSpacing& spacing, std::span<const Point3> points,
                           const std::stop_token& stop) {
    PeriodicCopies copies(domain, spacing, points);
    TetrahedronMesh mesh{{points.begin(), points.end()}, {}};
    for (bool is_complete = false; !is_complete && !stop.stop_requested();) {
        is_complete = true;
        mesh.tetrahedra.clear();
        for (const Tetrahedron& corners : delaunay_tetrahedra(copies.positions(), stop)) {
            const auto is_original = [&](std::uint32_t corner) { return corner < points.size(); };
            if (std::ranges::none_of(corners, is_original)) continue;
            if (copies.complete(corners)) is_complete = false;
            // Of all periodic copies of a tetrahedron, the mesh contains the one whose lowest vertex is an original.
            const auto lowest = std::ranges::min(corners, {}, [&](std::uint32_t corner) {
                return std::array{copies.number(corner), corner};
            });
            if (!is_original(lowest)) continue;
            const auto& [a, b, c, d] = corners;
            mesh.tetrahedra.push_back({copies.number(a), copies.number(b), copies.number(c), copies.number(d)});
        }
    }
    return mesh;
}

TetrahedronMesh box_mesh(const BoxDomain3& domain, const VolumeSpacing& spacing, std::span<const Point3> points,
                         const std::stop_token& stop) {
    TetrahedronMesh mesh{{points.begin(), points.end()}, {}};
    std::vector<Point3>& vertices = mesh.vertices;
    for (const Point3 p : points) {
        std::vector<Point3> projections{p};
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double v = along(p, axis), side = along(domain.sides, axis);
            const double face = v < side - v ? 0 : side;
            if (std::abs(v - face) > kFirstLayer * spacing.side(p)) continue;
            const std::size_t so_far = projections.size();
            for (std::size_t i = 0; i < so_far; ++i) {
                Point3 projection = projections[i];
                along(projection, axis) = face;
                projections.push_back(projection);
            }
        }
        // The last one of eight projections is a corner of the box, which is added below.
        const bool has_corner = projections.size() == 8;
        vertices.insert(vertices.end(), projections.begin() + 1, projections.end() - (has_corner ? 1 : 0));
    }
    for (const double z : {0.0, domain.sides.z}) {
        for (const double y : {0.0, domain.sides.y}) {
            for (const double x : {0.0, domain.sides.x}) vertices.push_back({x, y, z});
        }
    }
    mesh.tetrahedra = delaunay_tetrahedra(vertices, stop);
    return mesh;
}

}  // namespace

TetrahedronMesh volume_mesh(const BoxDomain3& domain, const VolumeSpacing& spacing, std::span<const Point3> points,
                            std::size_t free, const std::stop_token& stop) {
    TetrahedronMesh mesh =
        domain.periodic ? torus_mesh(domain, spacing, points, stop) : box_mesh(domain, spacing, points, stop);
    const Point3 sides = domain.sides;
    if (domain.periodic && std::min({sides.x, sides.y, sides.z}) < kNarrowest * spacing.mean()) return mesh;
    const auto slide = [&](std::uint32_t v, Point3 to) {
        if (v < free) return domain.inside(to);
        const Point3 from = mesh.vertices[v];
        if (v < points.size()) return from;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const double side = along(sides, axis), own = along(from, axis);
            along(to, axis) = own == 0 || own == side ? own : std::clamp(along(to, axis), 0.0, side);
        }
        return to;
    };
    improve_tetrahedra(mesh, domain.periodic ? sides : Point3{}, slide, stop);
    return mesh;
}

}  // namespace ccdt
