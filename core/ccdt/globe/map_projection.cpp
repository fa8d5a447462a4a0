// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/globe/map_projection.h"

#include <limits>
#include <vector>

#include "core/base/elementary.h"
#include "core/ccdt/globe/ellipsoid.h"

namespace ccdt {

namespace {

const double kEccentricity = std::sqrt(kSquaredEccentricity);

/// Returns the quantity q of Snyder's equation 3-12: the area between the equator and a parallel, up to a factor.
/// @param sine  of the geodetic latitude
double zone(double sine) {
    const double across = kEccentricity * sine;
    const double artanh = elementary::log1p(2 * across / (1 - across)) / 2;
    return (1 - kSquaredEccentricity) * (sine / (1 - across * across) + artanh / kEccentricity);
}

/// Returns the sine of the authalic latitude.
/// @param latitude  geodetic, degrees
double authalic_sine(double latitude) {
    static const double kZone = zone(1);
    return std::abs(latitude) >= 90 ? std::copysign(1.0, latitude) : zone(elementary::sin(latitude * kDegree)) / kZone;
}

double cosine_of(double sine) {
    return std::sqrt(std::max(0.0, 1 - sine * sine));
}

/// Range of longitudes, and its length.
struct Longitudes {
    double west = 0, length = kTurn;
};

/// Returns the shortest range of longitudes that contains all parts.
Longitudes range_of(std::span<const PolygonPart> parts) {
    constexpr double kMinGap = 1e-3;
    std::vector<Longitudes> ranges;
    double end = -2 * kTurn;  // of the ranges so far; first, of those that continue from the turn before
    for (const PolygonPart& part : parts) {
        if (part.outer.empty()) continue;
        const auto [west, east] = std::ranges::minmax_element(part.outer, {}, &Point::x);
        const double start = west->x + longitude_wrap_offset(west->x, -kTurn / 2);
        ranges.push_back({start, east->x - west->x});
        end = std::max(end, start + ranges.back().length - kTurn);
    }
    std::ranges::sort(ranges, {}, &Longitudes::west);
    Longitudes longest{-kTurn / 2, 0};  // gap between ranges, by its eastern end
    for (const auto& [west, length] : ranges) {
        if (west - end > std::max(longest.length, kMinGap)) longest = {west, west - end};
        end = std::max(end, west + length);
    }
    return {longest.west, kTurn - longest.length};
}

Point latitudes_of(std::span<const PolygonPart> parts) {
    Point range{90, -90};
    for (const PolygonPart& part : parts) {
        for (const Point& p : part.outer) range = {std::min(range.x, p.y), std::max(range.y, p.y)};
    }
    return range;
}

}  // namespace

double ground_area(const Domain& degrees) {
    double sum = 0;
    for (const Ring& ring : degrees.rings()) {
        Point a = degrees.to_user(ring.back());
        for (const Point& corner : ring) {
            const Point b = degrees.to_user(corner);
            // Simpson's rule for the area below the edge.
            const double height = authalic_sine(a.y) + 4 * authalic_sine((a.y + b.y) / 2) + authalic_sine(b.y);
            sum -= (b.x - a.x) * height / 6;
            a = b;
        }
    }
    return sum / kDegree;
}

MapProjection::MapProjection(bool is_world, Point middle)
    : is_world_(is_world), longitude_(middle.x), sine_(authalic_sine(middle.y)), cosine_(cosine_of(sine_)) {
    if (is_world || std::abs(middle.y) == 90) return;
    static const double kRadius = std::sqrt(zone(1) / 2);  // of the sphere, in equatorial radii
    const double sine = elementary::sin(middle.y * kDegree);
    stretch_ = cosine_of(sine) / std::sqrt(1 - kSquaredEccentricity * sine * sine) / (kRadius * cosine_);
}

MapProjection MapProjection::fitting(std::span<const PolygonPart> parts) {
    const Longitudes range = range_of(parts);
    const auto [south, north] = latitudes_of(parts);
    const double longitude = range.west + range.length / 2;
    const double latitude = (south + north) / 2;
    const auto is_near = [&](double corner) {
        return elementary::sin(latitude * kDegree) * elementary::sin(corner * kDegree) +
                   elementary::cos(latitude * kDegree) * elementary::cos(corner * kDegree) *
                       elementary::cos(range.length / 2 * kDegree) >
               0;
    };
    if (range.length <= kTurn / 2 && is_near(south) && is_near(north)) return {false, {longitude, latitude}};
    if (south >= 0 || north <= 0) return {false, {longitude, south >= 0 ? 90.0 : -90.0}};
    return {true, {longitude, 0}};
}

Point MapProjection::operator()(Point position) const {
    return project(std::remainder(position.x - longitude_, kTurn), position.y);
}

Point MapProjection::project(double east, double latitude) const {
    const double sine = authalic_sine(latitude), cosine = cosine_of(sine);
    if (is_world_) {
        // Equations 8 and 9 of Savric et al.
        constexpr double kA1 = 1.340264, kA2 = -0.081106, kA3 = 0.000893, kA4 = 0.003796;
        static const double kM = std::sqrt(3.0) / 2;
        const double theta = elementary::atan2(kM * sine, cosine_of(kM * sine));
        const double square = theta * theta, cube = square * square * square;
        const double slope = kA1 + 3 * kA2 * square + cube * (7 * kA3 + 9 * kA4 * square);
        return {east * cosine_of(kM * sine) / (kM * slope),
                theta / kDegree * (kA1 + kA2 * square + cube * (kA3 + kA4 * square))};
    }
    const double along = cosine * elementary::cos(east * kDegree);
    constexpr double kMin = 1e-12;  // the point opposite the middle maps to a point of the outermost circle
    const double scale = std::sqrt(2 / std::max(1 + sine_ * sine + cosine_ * along, kMin)) / kDegree;
    return {scale * stretch_ * cosine * elementary::sin(east * kDegree),
            scale / stretch_ * (cosine_ * sine - sine_ * along)};
}

}  // namespace ccdt
