// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/geometry/simplify.h"

#include <algorithm>
#include <cstddef>
#include <span>

namespace ccdt {

namespace {

double squared_distance(Point a, Point b, Point p) {
    const Point along = b - a, from = p - a;
    const double squared = dot(along, along);
    const double at = squared > 0 ? std::clamp(dot(from, along) / squared, 0.0, 1.0) : 0;
    const Point off = from - at * along;
    return dot(off, off);
}

/// Appends the retained corners of a chain, except its last corner.
void append_simplified(std::span<const Point> chain, double distance, Ring& kept) {
    double farthest = 0;
    std::size_t split = 0;
    for (std::size_t i = 1; i + 1 < chain.size(); ++i) {
        const double squared = squared_distance(chain.front(), chain.back(), chain[i]);
        if (squared <= farthest) continue;
        farthest = squared;
        split = i;
    }
    if (farthest <= distance * distance) return kept.push_back(chain.front());
    append_simplified(chain.first(split + 1), distance, kept);
    append_simplified(chain.subspan(split), distance, kept);
}

}  // namespace

Ring simplified(const Ring& ring, double distance) {
    constexpr std::size_t kTogether = 256;
    Ring closed = ring, kept;
    closed.push_back(ring.front());
    for (std::size_t first = 0; first < ring.size(); first += kTogether) {
        const std::size_t edges = std::min(kTogether, ring.size() - first);
        append_simplified(std::span<const Point>(closed).subspan(first, edges + 1), distance, kept);
    }
    return kept.size() < 3 ? ring : kept;
}

}  // namespace ccdt
