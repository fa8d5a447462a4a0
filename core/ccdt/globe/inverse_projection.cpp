// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/globe/inverse_projection.h"

#include <cmath>
#include <vector>

#include "core/base/elementary.h"
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
    const Point position = position_of(chart.to_direction(plane));
    const Point turned{position.x + longitude_wrap_offset(position.x, west_), position.y};
    const Point nudged = inside_.nearest(turned, elementary::cos(position.y * kDegree));
    return nudged == turned ? position : Point{std::remainder(nudged.x, kTurn), nudged.y};
}

}  // namespace ccdt
