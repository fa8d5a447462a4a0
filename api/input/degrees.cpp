// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/input/degrees.h"

#include <algorithm>
#include <cmath>

#include "api/text/numbers.h"
#include "core/base/elementary.h"
#include "core/ccdt/globe/turns.h"

namespace ccdt::api {
namespace {

constexpr double kMinRatio = 1.1, kMaxRatio = 100;

double cosine(double degrees) {
    return elementary::cos(degrees * kDegree);
}

}  // namespace

std::optional<std::string> warning_of_degrees(const Box& bounds) {
    const double south = bounds.min.y, north = bounds.max.y;
    if (bounds.min.x < -180 || bounds.max.x > 180 || south < -90 || north > 90) return std::nullopt;
    const double nearest = south <= 0 && north >= 0 ? 0 : std::min(std::abs(south), std::abs(north));
    const double farthest = std::max(std::abs(south), std::abs(north));
    // A degree of longitude is shorter at the latitude `farthest` than at `nearest`, by this factor. The number of
    // points per square kilometre is larger by the same factor.
    const double ratio = cosine(nearest) / std::max(cosine(farthest), cosine(nearest) / kMaxRatio);
    if (ratio < kMinRatio) return std::nullopt;
    std::string text =
        "points are even in degrees, not on the ground: if these are longitudes and latitudes, there are ";
    append_rounded(text, ratio, 2);
    text += ratio < kMaxRatio ? " times" : " times or more";
    text += " as many to a square kilometre at latitude ";
    append_rounded(text, south + north >= 0 ? north : south, 2);
    text += " as at ";
    append_rounded(text, nearest == 0 ? 0 : south + north >= 0 ? south : north, 2);
    return text;
}

}  // namespace ccdt::api
