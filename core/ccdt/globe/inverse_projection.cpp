// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/globe/inverse_projection.h"

#include <cmath>
#include <vector>

#include "core/ccdt/globe/turns.h"

namespace ccdt {

namespace {

std::vector<Ring> rings_of(const Domain& degrees) {
    std::vector<Ring> rings = degrees.rings();
    for (Ring& ring : rings) {
        for (Point& p : ring) p = degrees.to_user(p);
    }
    return rings;
}

}  // namespace

InverseProjection::InverseProjection(const Domain& degrees)
    : west_(degrees.bounds().min.x), inside_(rings_of(degrees)) {}

Point InverseProjection::operator()(const Chart& chart, Point plane) const {
    const Point place = place_of(chart.to_direction(plane));
    const Point turned{place.x + longitude_wrap_offset(place.x, west_), place.y};
    const Point nudged = inside_.nearest(turned, std::cos(place.y * kDegree));
    return nudged == turned ? place : Point{std::remainder(nudged.x, kTurn), nudged.y};
}

}  // namespace ccdt
