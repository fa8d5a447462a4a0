#include "core/geometry/domain.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <optional>
#include <string>

#include "core/geometry/delaunay.h"

namespace ccdt {

namespace {

constexpr std::uint32_t kNone = ~std::uint32_t{0};

/// A ring on its way into a domain, with the way back to what the caller wrote.
struct RingInput {
    std::size_t part = 0;
    std::size_t ring = 0;             ///< 0 is the outer one
    Ring corners;                     ///< repeated ones dropped
    std::vector<std::size_t> source;  ///< the caller's index of each corner

    bool is_hole() const { return ring > 0; }

    std::string name() const {
        const std::string of = part > 0 || ring == 0 ? " of part " + std::to_string(part) : "";
        return ring == 0 ? "the outer ring" + of : "hole " + std::to_string(ring - 1) + of;
    }
    std::string pointer() const { return "/" + std::to_string(part) + "/" + std::to_string(ring); }
    std::string pointer(std::size_t corner) const { return pointer() + "/" + std::to_string(source[corner]); }
};

std::string vertex_name(const RingInput& ring, std::size_t corner) {
    return "vertex " + std::to_string(ring.source[corner]) + " of " + ring.name();
}

bool is_finite(Point p) {
    return std::isfinite(p.x) && std::isfinite(p.y);
}

Result<RingInput> read_ring(const Ring& given, std::size_t part, std::size_t number) {
    RingInput ring{part, number, {}, {}};
    for (std::size_t i = 0; i < given.size(); ++i) {
        if (!is_finite(given[i])) {
            return failure(ErrorCode::Unusable, "vertex " + std::to_string(i) + " of " + ring.name() + " is not finite",
                           ring.pointer() + "/" + std::to_string(i));
        }
        if (!ring.corners.empty() && ring.corners.back() == given[i]) continue;
        ring.corners.push_back(given[i]);
        ring.source.push_back(i);
    }
    while (ring.corners.size() > 1 && ring.corners.front() == ring.corners.back()) {
        ring.corners.pop_back();
        ring.source.pop_back();
    }
    if (ring.corners.size() < 3) {
        return failure(ErrorCode::Unusable, ring.name() + " needs at least 3 distinct vertices", ring.pointer());
    }
    return ring;
}

Result<std::vector<RingInput>> read_rings(const std::vector<PolygonPart>& parts) {
    std::vector<RingInput> rings;
    for (std::size_t p = 0; p < parts.size(); ++p) {
        for (std::size_t r = 0; r <= parts[p].holes.size(); ++r) {
            auto ring = read_ring(r == 0 ? parts[p].outer : parts[p].holes[r - 1], p, r);
            if (!ring) return tl::unexpected(ring.error());
            rings.push_back(std::move(*ring));
        }
    }
    if (rings.empty()) return failure(ErrorCode::Unusable, "a domain needs at least one polygon");
    return rings;
}

Box bounds_of(const std::vector<RingInput>& rings) {
    Box box{rings[0].corners[0], rings[0].corners[0]};
    for (const RingInput& ring : rings) {
        for (const Point& p : ring.corners) box.include(p);
    }
    return box;
}

double signed_area(const Ring& ring) {
    double doubled = 0;
    for (std::size_t i = 0; i < ring.size(); ++i) doubled += cross(ring[i], ring[(i + 1) % ring.size()]);
    return doubled / 2;
}

/// Tells whether all corners lie on one line, as nearly as the area spanned can tell. The area of a ring that crosses
/// itself may cancel out: what is wrong with that one is the crossing.
bool is_collinear(const Ring& ring, double min_area) {
    double spanned = 0;
    for (std::size_t i = 2; i < ring.size(); ++i) {
        spanned += std::abs(cross(ring[i - 1] - ring[0], ring[i] - ring[0])) / 2;
    }
    return spanned < min_area;
}

tl::unexpected<Error> zero_area(const RingInput& ring) {
    return failure(ErrorCode::Unusable, ring.name() + " has zero area", ring.pointer());
}

double length(const Ring& ring) {
    double sum = 0;
    for (std::size_t i = 0; i < ring.size(); ++i) {
        const Point edge = ring[(i + 1) % ring.size()] - ring[i];
        sum += std::sqrt(dot(edge, edge));
    }
    return sum;
}

/// Drops corners that normalising made equal to the one before.
void drop_repeated(RingInput& ring) {
    std::size_t kept = 0;
    for (std::size_t i = 0; i < ring.corners.size(); ++i) {
        const std::size_t before = kept > 0 ? kept - 1 : ring.corners.size() - 1;
        if (ring.corners[i] == ring.corners[before]) continue;
        ring.corners[kept] = ring.corners[i];
        ring.source[kept++] = ring.source[i];
    }
    ring.corners.resize(kept);
    ring.source.resize(kept);
}

void orient(RingInput& ring) {
    if ((signed_area(ring.corners) < 0) == ring.is_hole()) return;
    std::reverse(ring.corners.begin(), ring.corners.end());
    std::reverse(ring.source.begin(), ring.source.end());
}

/// Points and segments of all rings, and which corner of which ring each point is.
struct Outline {
    std::vector<Point> points;
    std::vector<Segment> segments;
    std::vector<std::uint32_t> ring_of;
    std::vector<std::uint32_t> corner_of;
};

Outline outline_of(const std::vector<RingInput>& rings) {
    Outline outline;
    for (std::size_t r = 0; r < rings.size(); ++r) {
        const auto first = static_cast<std::uint32_t>(outline.points.size());
        const auto size = static_cast<std::uint32_t>(rings[r].corners.size());
        for (std::uint32_t i = 0; i < size; ++i) {
            outline.points.push_back(rings[r].corners[i]);
            outline.segments.push_back({first + i, first + (i + 1) % size});
            outline.ring_of.push_back(static_cast<std::uint32_t>(r));
            outline.corner_of.push_back(i);
        }
    }
    return outline;
}

std::optional<Error> find_shared_corner(const std::vector<RingInput>& rings, const Outline& outline) {
    std::vector<std::uint32_t> order(outline.points.size());
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(), [&](std::uint32_t a, std::uint32_t b) {
        const Point p = outline.points[a], q = outline.points[b];
        return p.x != q.x ? p.x < q.x : p.y != q.y ? p.y < q.y : a < b;
    });
    for (std::size_t i = 1; i < order.size(); ++i) {
        const std::uint32_t a = order[i - 1], b = order[i];
        if (outline.points[a] != outline.points[b]) continue;
        const RingInput& ring = rings[outline.ring_of[b]];
        return Error{ErrorCode::Unusable,
                     vertex_name(ring, outline.corner_of[b]) + " touches " +
                         vertex_name(rings[outline.ring_of[a]], outline.corner_of[a]),
                     ring.pointer(outline.corner_of[b])};
    }
    return std::nullopt;
}

/// Finds the ring directly around each ring, kNone for none. Each constrained edge belongs to one ring, and
/// crossing it from outside enters that ring.
std::vector<std::uint32_t> surrounding_rings(const ConstrainedDelaunay& mesh, const Outline& outline,
                                             std::size_t ring_count) {
    std::vector<std::uint32_t> parent(ring_count, kNone);
    std::vector<bool> entered(ring_count, false);
    std::vector<std::uint32_t> region(mesh.triangles.size(), kNone);  // ring around each triangle
    std::vector<bool> seen(mesh.triangles.size(), false);
    std::vector<std::uint32_t> stack;
    for (std::uint32_t t = 0; t < mesh.triangles.size() && stack.empty(); ++t) {
        const auto& neighbours = mesh.triangles[t].neighbours;
        if (std::find(neighbours.begin(), neighbours.end(), ConstrainedDelaunay::kNone) == neighbours.end()) continue;
        stack.push_back(t);
        seen[t] = true;
    }
    while (!stack.empty()) {
        const std::uint32_t t = stack.back();
        stack.pop_back();
        const auto& triangle = mesh.triangles[t];
        for (std::size_t i = 0; i < 3; ++i) {
            const std::uint32_t next = triangle.neighbours[i];
            if (next == ConstrainedDelaunay::kNone || seen[next]) continue;
            seen[next] = true;
            region[next] = region[t];
            if (triangle.constrained[i]) {
                const std::uint32_t ring = outline.ring_of[triangle.corners[i]];
                if (region[t] == ring) {
                    region[next] = parent[ring];
                } else {
                    if (!entered[ring]) parent[ring] = region[t];
                    entered[ring] = true;
                    region[next] = ring;
                }
            }
            stack.push_back(next);
        }
    }
    return parent;
}

std::optional<Error> find_misplaced_ring(const std::vector<RingInput>& rings,
                                         const std::vector<std::uint32_t>& parent) {
    for (std::size_t r = 0; r < rings.size(); ++r) {
        const RingInput& ring = rings[r];
        const RingInput* around = parent[r] == kNone ? nullptr : &rings[parent[r]];
        if (ring.is_hole() && (!around || around->part != ring.part)) {
            return Error{ErrorCode::Unusable, ring.name() + " lies outside its polygon", ring.pointer()};
        }
        if (ring.is_hole() && around->is_hole()) {
            return Error{ErrorCode::Unusable, ring.name() + " lies inside " + around->name(), ring.pointer()};
        }
        if (!ring.is_hole() && around && !around->is_hole()) {
            return Error{ErrorCode::Unusable, ring.name() + " overlaps " + around->name(), ring.pointer()};
        }
    }
    return std::nullopt;
}

std::optional<Error> find_conflict(const std::vector<RingInput>& rings, const std::stop_token& stop) {
    const Outline outline = outline_of(rings);
    if (auto error = find_shared_corner(rings, outline)) return error;
    const auto mesh = constrained_delaunay(outline.points, outline.segments, stop);
    if (stop.stop_requested()) return Error{ErrorCode::Stopped, "stopped before the polygon was validated", ""};
    if (!mesh) {
        const std::uint32_t point = outline.segments[mesh.error().segment][0];
        const RingInput& ring = rings[outline.ring_of[point]];
        return Error{ErrorCode::Unusable,
                     "the edge at " + vertex_name(ring, outline.corner_of[point]) + " crosses or touches another edge",
                     ring.pointer(outline.corner_of[point])};
    }
    return find_misplaced_ring(rings, surrounding_rings(*mesh, outline, rings.size()));
}

}  // namespace

Result<Domain> Domain::create(const std::vector<PolygonPart>& parts, const std::stop_token& stop) {
    // A ring whose area is below this share of the bounding box's larger side squared has no room for rounding.
    constexpr double kMinArea = 1e-12;
    // Squares of lengths, and their sums, must be finite and keep all their digits.
    constexpr double kMinExtent = 1e-140, kMaxExtent = 1e140;
    // Coordinates must resolve the domain: its size may not drown in their magnitude.
    constexpr double kMinSize = 1e-9;
    // So may not its thickness, in units of what rounding can move a point.
    constexpr double kMinThickness = 1000;

    auto rings = read_rings(parts);
    if (!rings) return tl::unexpected(rings.error());
    Domain domain;
    domain.bounds_ = bounds_of(*rings);
    const Box& box = domain.bounds_;
    domain.scale_ = std::max(box.width(), box.height());
    const double magnitude =
        std::max({std::abs(box.min.x), std::abs(box.min.y), std::abs(box.max.x), std::abs(box.max.y)});
    if (!(domain.scale_ >= kMinExtent && domain.scale_ <= kMaxExtent) || domain.scale_ < kMinSize * magnitude) {
        return failure(ErrorCode::Unusable, "the polygon's extent is too large, or too small for its coordinates",
                       "/0/0");
    }
    const auto to_unit = [scale = domain.scale_](double distance) {
        return distance < kLeast * scale ? 0 : distance / scale;
    };
    for (RingInput& ring : *rings) {
        for (Point& p : ring.corners) p = {to_unit(p.x - box.min.x), to_unit(p.y - box.min.y)};
        drop_repeated(ring);
        if (is_collinear(ring.corners, kMinArea)) return zero_area(ring);
        orient(ring);
    }
    if (auto error = find_conflict(*rings, stop)) return tl::unexpected(*error);
    for (const RingInput& ring : *rings) {
        if (std::abs(signed_area(ring.corners)) < kMinArea) return zero_area(ring);
    }

    domain.unit_size_ = {box.width() / domain.scale_, box.height() / domain.scale_};
    double perimeter = 0;
    for (RingInput& ring : *rings) {
        domain.unit_area_ += signed_area(ring.corners);
        perimeter += length(ring.corners);
        domain.rings_.push_back(std::move(ring.corners));
    }
    if (domain.unit_area_ < kMinThickness * domain.resolution() * perimeter) {
        return failure(ErrorCode::Unusable, "the polygon is too thin for the precision of its coordinates", "/0/0");
    }
    domain.is_box_ = domain.rings_.size() == 1 && domain.rings_[0].size() == 4 &&
                     domain.unit_area_ == domain.unit_size_.x * domain.unit_size_.y;
    return domain;
}

Result<Domain> Domain::rectangle(double width, double height) {
    return create({PolygonPart{{{0, 0}, {width, 0}, {width, height}, {0, height}}, {}}});
}

Result<Domain> Domain::torus(double width, double height) {
    constexpr double kMostStretched = 1000;
    constexpr double kGrid = 0x1p50;
    const double longer = std::max(width, height), shorter = std::min(width, height);
    if (!(shorter > 0) || !(longer <= kMostStretched * shorter)) {
        return failure(ErrorCode::Unusable, "a torus needs positive sides, one at most 1000 times the other");
    }
    auto torus = rectangle(width, height);
    if (!torus) return torus;
    torus->rings_.clear();
    torus->is_torus_ = true;
    Point& sides = torus->unit_size_;
    sides = {std::round(kGrid * sides.x) / kGrid, std::round(kGrid * sides.y) / kGrid};
    torus->unit_area_ = sides.x * sides.y;
    return torus;
}

double Domain::area() const {
    return unit_area_ * scale_ * scale_;
}

std::size_t Domain::corner_count() const {
    std::size_t count = 0;
    for (const Ring& ring : rings_) count += ring.size();
    return count;
}

double Domain::resolution() const {
    constexpr double kRoundings = 16;  // of corners on their way in, of products and sums on the way out, with room
    const double magnitude =
        std::max({std::abs(bounds_.min.x), std::abs(bounds_.min.y), std::abs(bounds_.max.x), std::abs(bounds_.max.y)});
    return kRoundings * std::numeric_limits<double>::epsilon() * magnitude / scale_;
}

Point Domain::to_user(Point unit) const {
    if (!is_torus_) return bounds_.min + scale_ * unit;
    const Point p = scale_ * wrapped(unit, unit_size_);  // may round up to the upper sides
    return {p.x < bounds_.max.x ? p.x : 0, p.y < bounds_.max.y ? p.y : 0};
}

}  // namespace ccdt
