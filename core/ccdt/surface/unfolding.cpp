// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/surface/unfolding.h"

namespace ccdt {

std::vector<std::uint8_t> sharp_components(const Surface& surface) {
    std::vector<std::uint8_t> sharp(surface.component_count(), 0);
    for (std::uint32_t h = 0; h < 4 * surface.face_count(); ++h) {
        if (h % 4 == 3 || surface.twin(h) == Surface::kNone) continue;
        if (is_sharp(surface.normal(h / 4), surface.normal(surface.twin(h) / 4))) sharp[surface.component(h / 4)] = 1;
    }
    return sharp;
}

std::optional<Unfolded> unfolded(const Surface& surface, const SurfacePoint& from, Point3 straight, std::uint32_t face,
                                 double longest) {
    constexpr double kMinSquaredSine = 1e-12;  // thinner wedges consist of rounding errors
    constexpr int kMaxEdges = 16;              // limits the time where faces are much smaller than the spacing
    constexpr double kMaxOffset = 0.2;         // of the end of the line, relative to its length
    const Point3 first = surface.normal(from.face), second = surface.normal(face);
    const double cosine = dot(first, second), squared_sine = 1 - cosine * cosine;
    // Distance of each point from the plane of the other point's face. The sign depends on whether the fold is convex
    // or concave.
    const double before = dot(straight, second), after = -dot(straight, first);
    if (squared_sine < kMinSquaredSine || before * after < 0) return std::nullopt;
    const Point3 axis = cross(first, second);
    const Point3 flat = 1 / squared_sine * (dot(straight, axis) * axis + (before + after) * (second - cosine * first));
    if (dot(flat, flat) > longest * longest) return std::nullopt;
    const auto line = surface.trace_within(from, flat, kMaxEdges);
    if (!line) return Unfolded{flat, true};
    const Point3 off = surface.position(line->end) - surface.position(from) - straight;
    if (dot(off, off) > kMaxOffset * kMaxOffset * dot(flat, flat)) return std::nullopt;
    return Unfolded{flat, line->least_cosine < kSharpCosine};
}

}  // namespace ccdt
