// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/geometry/domain.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdint>
#include <optional>
#include <utility>

#include "core/geometry/delaunay.h"
#include "core/geometry/repair.h"
#include "core/geometry/ring_input.h"

namespace ccdt {

namespace {

// Smallest area relative to the square of the bounding box's longer side; smaller areas are lost in rounding errors.
constexpr double kMinArea = 1e-12;
// Squares of lengths, and their sums, must be finite and keep full precision.
constexpr double kMinExtent = 1e-140, kMaxExtent = 1e140;
// Smallest size relative to the magnitude of the coordinates; a smaller domain has too few distinct coordinates.
constexpr double kMinSize = 1e-9;
// Smallest thickness relative to the distance by which rounding moves a point.
constexpr double kMinThickness = 1000;

tl::unexpected<Error> no_area(const std::vector<RingInput>& rings) {
    return failure(ErrorCode::Unusable, "the polygon has no area", rings.size() == 1 ? rings.front().pointer() : "");
}

template <class Rings, class CornersOf>
std::optional<Box> bounds_of(const Rings& rings, CornersOf corners_of) {
    std::optional<Box> box;
    for (const auto& ring : rings) {
        for (const Point& p : corners_of(ring)) {
            if (!box) box = Box{p, p};
            box->include(p);
        }
    }
    return box;
}

/// @param box  none if there are no corners
Result<UnitFrame> find_frame(const std::optional<Box>& box, const std::vector<RingInput>& rings) {
    if (!box || box->min == box->max) return no_area(rings);
    const UnitFrame frame = UnitFrame::of(*box);
    const bool is_ordinary = frame.scale >= kMinExtent && frame.scale <= kMaxExtent;
    if (is_ordinary && frame.scale >= kMinSize * frame.magnitude()) return frame;
    return failure(ErrorCode::Unusable, "the polygon's extent is too large, or too small for its coordinates", "/0/0");
}

double to_unit(double distance, double scale) {
    return distance < Domain::kMin * scale ? 0 : distance / scale;
}

double signed_area(const Ring& ring) {
    double doubled = 0;
    for (std::size_t i = 0; i < ring.size(); ++i) doubled += cross(ring[i], ring[(i + 1) % ring.size()]);
    return doubled / 2;
}

double length(const Ring& ring) {
    double sum = 0;
    for (std::size_t i = 0; i < ring.size(); ++i) {
        const Point edge = ring[(i + 1) % ring.size()] - ring[i];
        sum += std::sqrt(dot(edge, edge));
    }
    return sum;
}

Point to_unit(const UnitFrame& frame, Point p) {
    const Point from_corner = p - frame.bounds.min;
    return {to_unit(from_corner.x, frame.scale), to_unit(from_corner.y, frame.scale)};
}

void orient(RingInput& ring) {
    if ((signed_area(ring.corners) < 0) == ring.is_hole()) return;
    std::reverse(ring.corners.begin(), ring.corners.end());
    std::reverse(ring.source.begin(), ring.source.end());
}

void move_to(const UnitFrame& frame, RingInput& ring) {
    for (Point& p : ring.corners) p = to_unit(frame, p);
    ring.drop_repeated();
}

/// Rings and the unit frame of their coordinates.
struct FramedRings {
    std::vector<RingInput> rings;
    UnitFrame frame;
};

Result<FramedRings> to_frame(const std::vector<PolygonPart>& parts) {
    auto given = read_rings(parts);
    if (!given) return tl::unexpected(given.error());
    const auto frame =
        find_frame(bounds_of(*given, [](const RingInput& ring) -> const Ring& { return ring.corners; }), *given);
    if (!frame) return tl::unexpected(frame.error());
    for (RingInput& ring : *given) move_to(*frame, ring);
    return FramedRings{*std::move(given), *frame};
}

/// Moves rings into the frame of their own bounding box. The box can be smaller than before if a repair dropped parts.
/// @param frame  the frame of the rings; replaced by the new frame
Result<std::vector<Ring>> tighten(std::vector<Ring> rings, UnitFrame& frame, const std::vector<RingInput>& given,
                                  const std::stop_token& stop) {
    // One pass suffices in all tests and fuzzing (Domain.*, Fuzz.repair, Fuzz.run_sample). Rounding in the tighter
    // frame could make another pass necessary.
    constexpr int kTries = 8;
    for (int i = 0; i < kTries; ++i) {
        const auto box = bounds_of(rings, [](const Ring& ring) -> const Ring& { return ring; });
        if (!box) return no_area(given);
        if (box->min == Point{} && box->max == frame.unit_size()) return rings;
        const auto tighter = find_frame(Box{frame.to_user(box->min), frame.to_user(box->max)}, given);
        if (!tighter) return tl::unexpected(tighter.error());
        for (Ring& ring : rings) {
            RingInput moved{0, 0, {}, std::vector<std::size_t>(ring.size())};
            for (const Point& p : ring) moved.corners.push_back(frame.to_user(p));
            move_to(*tighter, moved);
            ring = std::move(moved.corners);
        }
        frame = *tighter;
        auto enclosed = enclosed_together(rings, frame, stop);
        if (!enclosed) return enclosed;
        rings = *std::move(enclosed);
    }
    return failure(ErrorCode::Unusable, "the polygon is too thin for the precision of its coordinates", "/0/0");
}

}  // namespace

Result<Domain> Domain::create(const std::vector<PolygonPart>& parts, const std::stop_token& stop) {
    auto repaired = repair(parts, stop);
    if (!repaired) return tl::unexpected(repaired.error());
    if (repaired->repairs.empty()) return std::move(repaired->domain);
    const Repair& fault = repaired->repairs.front();
    return failure(ErrorCode::Unusable, fault.detail, fault.field);
}

Result<RepairedDomain> Domain::repair(const std::vector<PolygonPart>& parts, const std::stop_token& stop) {
    auto framed = to_frame(parts);
    if (!framed) return tl::unexpected(framed.error());
    auto& [given, frame] = *framed;
    for (RingInput& ring : given) orient(ring);
    auto enclosed = enclosed_area(given, frame, stop);
    if (!enclosed) return tl::unexpected(enclosed.error());

    auto kept = enclosed->repairs.empty() ? std::move(enclosed->rings)
                                          : tighten(std::move(enclosed->rings), frame, given, stop);
    if (!kept) return tl::unexpected(kept.error());
    auto domain = make(*std::move(kept), frame, given);
    if (!domain) return tl::unexpected(domain.error());
    return RepairedDomain{*std::move(domain), std::move(enclosed->repairs)};
}

Result<RepairedArea> Domain::repair_area(const std::vector<PolygonPart>& parts, const std::stop_token& stop) {
    auto framed = to_frame(parts);
    if (!framed) return tl::unexpected(framed.error());
    for (RingInput& ring : framed->rings) orient(ring);
    auto enclosed = enclosed_area(framed->rings, framed->frame, stop);
    if (!enclosed) return tl::unexpected(enclosed.error());
    RepairedArea area{{}, std::move(enclosed->repairs)};
    if (area.repairs.empty()) {
        // Valid input is kept unchanged.
        for (const auto& [outer, holes] : parts) {
            area.rings.push_back(outer);
            area.rings.insert(area.rings.end(), holes.begin(), holes.end());
        }
        return area;
    }
    area.rings = std::move(enclosed->rings);
    for (Ring& ring : area.rings) {
        for (Point& p : ring) p = framed->frame.to_user(p);
    }
    return area;
}

Result<Domain> Domain::enclosed_by(const std::vector<Ring>& rings, const std::stop_token& stop) {
    std::vector<PolygonPart> parts;
    parts.reserve(rings.size());
    for (const Ring& ring : rings) parts.push_back({ring, {}});
    auto framed = to_frame(parts);
    if (!framed) return tl::unexpected(framed.error());
    auto& [given, frame] = *framed;
    std::vector<Ring> moved;
    moved.reserve(given.size());
    for (RingInput& ring : given) moved.push_back(std::move(ring.corners));
    auto enclosed = enclosed_together(moved, frame, stop);
    if (!enclosed) return tl::unexpected(enclosed.error());
    auto kept = tighten(*std::move(enclosed), frame, given, stop);
    if (!kept) return tl::unexpected(kept.error());
    return make(*std::move(kept), frame, given);
}

Result<Domain> Domain::united(std::span<const Domain* const> domains, const std::stop_token& stop) {
    Box box = domains.front()->bounds();
    for (const Domain* each : domains) {
        box.include(each->bounds().min);
        box.include(each->bounds().max);
    }
    auto frame = find_frame(box, {});
    if (!frame) return tl::unexpected(frame.error());
    std::vector<Area> areas;
    for (const Domain* each : domains) {
        Area& area = areas.emplace_back();
        for (const Ring& ring : each->rings()) {
            RingInput moved{0, 0, {}, std::vector<std::size_t>(ring.size())};
            for (const Point& p : ring) moved.corners.push_back(each->to_user(p));
            move_to(*frame, moved);
            area.push_back(std::move(moved.corners));
        }
    }
    auto covered = ccdt::united(areas, frame->resolution(), stop);
    if (!covered) return tl::unexpected(covered.error());
    auto kept = tighten(*std::move(covered), *frame, {}, stop);
    if (!kept) return tl::unexpected(kept.error());
    return make(*std::move(kept), *frame, {});
}

Result<Domain> Domain::without(std::span<const Area> areas, const std::stop_token& stop) const {
    assert(!is_torus_);
    auto remaining = difference(rings_, areas, frame_.resolution(), stop);
    if (!remaining) return tl::unexpected(remaining.error());
    return within(*std::move(remaining));
}

Result<Domain> Domain::within(std::vector<Ring> rings) const {
    auto domain = make(std::move(rings), frame_, {});
    if (!domain) return failure(ErrorCode::Unusable, "nothing is left of the polygon");
    return domain;
}

Result<Domain> Domain::make(std::vector<Ring> rings, const UnitFrame& frame, const std::vector<RingInput>& given) {
    Domain domain;
    domain.frame_ = frame;
    domain.rings_ = std::move(rings);
    domain.unit_size_ = frame.unit_size();
    double perimeter = 0;
    for (const Ring& ring : domain.rings_) {
        domain.unit_area_ += signed_area(ring);
        perimeter += length(ring);
    }
    if (domain.unit_area_ < kMinArea) return no_area(given);
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
    constexpr double kMaxStretched = 1000;
    constexpr double kGrid = 0x1p50;
    const double longer = std::max(width, height), shorter = std::min(width, height);
    if (!(shorter > 0) || !(longer <= kMaxStretched * shorter)) {
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
    return unit_area_ * frame_.scale * frame_.scale;
}

std::size_t Domain::corner_count() const {
    std::size_t count = 0;
    for (const Ring& ring : rings_) count += ring.size();
    return count;
}

Point Domain::to_user(Point unit) const {
    if (!is_torus_) return frame_.to_user(unit);
    const Point p = frame_.scale * wrapped(unit, unit_size_);  // may round up to the upper sides
    return {p.x < bounds().max.x ? p.x : 0, p.y < bounds().max.y ? p.y : 0};
}

Point Domain::to_unit(Point user) const {
    if (!is_torus_) return ccdt::to_unit(frame_, user);
    return wrapped((1 / frame_.scale) * user, unit_size_);
}

}  // namespace ccdt
