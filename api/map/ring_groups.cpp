// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/map/ring_groups.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/geometry/point.h"

namespace ccdt::api {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

Box box_of(const Ring& ring) {
    Box box{{kInfinity, kInfinity}, {-kInfinity, -kInfinity}};
    for (const Point& p : ring) box.include(p);
    return box;
}

bool contains(const Box& outer, const Box& inner) {
    return outer.min.x <= inner.min.x && outer.min.y <= inner.min.y && outer.max.x >= inner.max.x &&
           outer.max.y >= inner.max.y;
}

/// Computes twice the area of a ring, which is positive for counter-clockwise rings. Returns 0 if the result is not a
/// number because of overflow.
double doubled_area(const Ring& ring) {
    double sum = 0;
    for (std::size_t i = 2; i < ring.size(); ++i) sum += cross(ring[i - 1] - ring[0], ring[i] - ring[0]);
    return std::isnan(sum) ? 0 : sum;
}

enum class Side { Inside, Outside, Border };

/// Returns the side of a ring on which a point lies. Counts the crossings of the ring with a ray to the right of the
/// point.
Side side_of(const Ring& ring, Point p) {
    bool is_inside = false;
    for (std::size_t i = 0; i < ring.size(); ++i) {
        const Point a = ring[i];
        const Point b = ring[(i + 1) % ring.size()];
        const double turn = cross(b - a, p - a);
        const bool is_between = std::min(a.x, b.x) <= p.x && p.x <= std::max(a.x, b.x) && std::min(a.y, b.y) <= p.y &&
                                p.y <= std::max(a.y, b.y);
        if (turn == 0 && is_between) return Side::Border;
        if ((a.y <= p.y) != (b.y <= p.y) && (turn > 0) == (a.y < b.y)) is_inside = !is_inside;
    }
    return is_inside ? Side::Inside : Side::Outside;
}

/// Returns whether the outer ring contains the inner ring. The rings may touch but must not cross.
bool contains(const Ring& outer, const Ring& inner) {
    for (const Point& p : inner) {
        const Side side = side_of(outer, p);
        if (side != Side::Border) return side == Side::Inside;
    }
    return true;
}

/// Outer rings of a shape, by increasing area. The plane is divided into horizontal rows; an index lists the rings that
/// overlap each row.
class OuterRings {
public:
    /// @param outers  indices of the outer rings
    OuterRings(std::span<const Ring> rings, std::span<const std::size_t> outers) : rings_(rings) {
        for (const std::size_t ring : outers)
            outers_.push_back({ring, -doubled_area(rings[ring]), box_of(rings[ring])});
        std::ranges::stable_sort(outers_, {}, &Outer::area);
        for (const Outer& outer : outers_) {
            bottom_ = std::min(bottom_, outer.box.min.y);
            top_ = std::max(top_, outer.box.max.y);
        }
        rows_.resize(static_cast<std::size_t>(std::sqrt(outers_.size())) + 1);
        for (std::size_t i = 0; i < outers_.size(); ++i) {
            const std::size_t last = row_of(outers_[i].box.max.y);
            for (std::size_t row = row_of(outers_[i].box.min.y); row <= last; ++row) rows_[row].push_back(i);
        }
    }

    /// Finds the smallest outer ring that contains a hole.
    std::optional<std::size_t> find(const Ring& hole) {
        const Box box = box_of(hole);
        candidates_.clear();
        for (const std::size_t i : rows_[row_of(box.min.y)]) {
            if (contains(outers_[i].box, box)) candidates_.push_back(outers_[i].ring);
        }
        if (candidates_.size() == 1) return candidates_.front();
        const auto found =
            std::ranges::find_if(candidates_, [&](std::size_t candidate) { return contains(rings_[candidate], hole); });
        return found == candidates_.end() ? std::nullopt : std::optional(*found);
    }

private:
    struct Outer {
        std::size_t ring = 0;
        double area = 0;
        Box box;
    };

    /// Returns the row that contains y. The row never decreases as y increases.
    std::size_t row_of(double y) const {
        const double row = (y - bottom_) / (top_ - bottom_) * static_cast<double>(rows_.size());
        return row > 0 ? static_cast<std::size_t>(std::min(row, static_cast<double>(rows_.size() - 1))) : 0;
    }

    std::span<const Ring> rings_;
    std::vector<Outer> outers_;
    double bottom_ = kInfinity;
    double top_ = -kInfinity;
    std::vector<std::vector<std::size_t>> rows_;  ///< indices of the outer rings in each row, by increasing area
    std::vector<std::size_t> candidates_;
};

}  // namespace

std::vector<std::vector<std::size_t>> group_rings(std::span<const Ring> rings) {
    std::vector<std::size_t> owners(rings.size());
    std::vector<std::size_t> outers;
    std::vector<std::size_t> holes;
    for (std::size_t i = 0; i < rings.size(); ++i) {
        owners[i] = i;
        (doubled_area(rings[i]) > 0 ? holes : outers).push_back(i);
    }
    OuterRings index(rings, outers);
    for (const std::size_t hole : holes) owners[hole] = index.find(rings[hole]).value_or(hole);

    std::vector<std::vector<std::size_t>> polygons;
    std::vector<std::size_t> polygon_of(rings.size());
    for (std::size_t i = 0; i < rings.size(); ++i) {
        if (owners[i] != i) continue;
        polygon_of[i] = polygons.size();
        polygons.push_back({i});
    }
    for (const std::size_t hole : holes) {
        if (owners[hole] != hole) polygons[polygon_of[owners[hole]]].push_back(hole);
    }
    return polygons;
}

}  // namespace ccdt::api
