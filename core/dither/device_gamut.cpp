// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/dither/device_gamut.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace ccdt {

namespace {

using Vector = Lab;

Vector cross(const Vector& a, const Vector& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// A point as a mixture of the corners of a triangle.
using Weights = std::array<double, 3>;

/// Returns the point of the segment between two corners that is nearest to the origin.
Weights nearest_on_edge(const std::array<Vector, 3>& corners, std::size_t a, std::size_t b) {
    const Vector along = corners[b] - corners[a];
    const double square = dot(along, along);
    const double t = square > 0 ? std::clamp(-dot(corners[a], along) / square, 0.0, 1.0) : 0.0;
    Weights weights{};
    weights[a] = 1 - t;
    weights[b] = t;
    return weights;
}

Vector mixture(const std::array<Vector, 3>& corners, const Weights& weights) {
    Vector sum{};
    for (std::size_t i = 0; i < corners.size(); ++i) {
        for (std::size_t c = 0; c < sum.size(); ++c) sum[c] += weights[i] * corners[i][c];
    }
    return sum;
}

/// Returns the point of a triangle that is nearest to the origin. The triangle may be a segment or a point.
Weights nearest_on_triangle(const std::array<Vector, 3>& corners) {
    const Vector normal = cross(corners[1] - corners[0], corners[2] - corners[0]);
    const double square = dot(normal, normal);
    if (square > 0) {
        Weights inside{};
        for (std::size_t i = 0; i < corners.size(); ++i)
            inside[i] = dot(normal, cross(corners[(i + 1) % 3], corners[(i + 2) % 3])) / square;
        if (std::ranges::min(inside) >= 0) return inside;
    }
    Weights best{};
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < corners.size(); ++i) {
        const Weights weights = nearest_on_edge(corners, i, (i + 1) % 3);
        const Vector point = mixture(corners, weights);
        if (const double distance = dot(point, point); distance < least) {
            least = distance;
            best = weights;
        }
    }
    return best;
}

/// Returns the derivatives of CIELAB with respect to light [L*, a*, b*][red, green, blue].
std::array<Vector, 3> lab_slopes(const Vector& light) {
    // Near black, the slopes of a dark grey are used, because the eye adapts to the surroundings.
    constexpr double kStep = 1e-3, kMin = 0.01;
    Vector at = light;
    for (double& value : at) value = std::max(value, kMin);
    const Lab from = lab_of(at);
    std::array<Vector, 3> slopes{};
    for (std::size_t c = 0; c < at.size(); ++c) {
        Vector next = at;
        next[c] += kStep;
        const Lab to = lab_of(next);
        for (std::size_t i = 0; i < slopes.size(); ++i) slopes[i][c] = (to[i] - from[i]) / kStep;
    }
    return slopes;
}

}  // namespace

DeviceGamut::DeviceGamut(std::span<const Light> colours) {
    constexpr double kFlat = 1e-9;  // largest volume that counts as 0; the cube of all light has 1
    assert(colours.size() >= 2);
    for (const Light& light : colours) colours_.push_back({light.red, light.green, light.blue});
    is_flat_ = true;
    std::vector<Facet> triangles;
    for (std::size_t i = 0; i < colours_.size(); ++i) {
        for (std::size_t j = i + 1; j < colours_.size(); ++j) {
            // With two colours, the only triangle repeats a corner.
            for (std::size_t k = std::min(j + 1, colours_.size() - 1); k < colours_.size(); ++k) {
                Facet triangle{{i, j, k}, cross(colours_[j] - colours_[i], colours_[k] - colours_[i])};
                double above = 0, below = 0;
                for (const Vector& colour : colours_) {
                    const double height = dot(triangle.outwards, colour - colours_[i]);
                    above = std::max(above, height);
                    below = std::min(below, height);
                }
                triangles.push_back(triangle);
                is_flat_ = is_flat_ && above < kFlat && below > -kFlat;
                if (above >= kFlat && below <= -kFlat) continue;  // the triangle is inside the hull
                if (below > -kFlat && above < kFlat) continue;    // its corners lie on a line
                if (above >= kFlat)
                    for (double& value : triangle.outwards) value = -value;
                facets_.push_back(triangle);
            }
        }
    }
    if (is_flat_) facets_ = std::move(triangles);
}

bool DeviceGamut::contains(const Vector& light) const {
    if (is_flat_) return false;
    return std::ranges::all_of(
        facets_, [&](const Facet& facet) { return dot(facet.outwards, light - colours_[facet.corners.front()]) <= 0; });
}

Light DeviceGamut::nearest(const Light& light) const {
    const Vector wanted{light.red, light.green, light.blue};
    if (contains(wanted)) return light;
    const std::array<Vector, 3> slopes = lab_slopes(wanted);
    std::vector<Vector> seen;  // differences from the wanted colour, in CIELAB
    for (const Vector& colour : colours_) {
        const Vector off = colour - wanted;
        seen.push_back({dot(slopes[0], off), dot(slopes[1], off), dot(slopes[2], off)});
    }
    Vector best{};
    double least = std::numeric_limits<double>::infinity();
    for (const Facet& facet : facets_) {
        const auto [a, b, c] = facet.corners;
        const std::array<Vector, 3> corners = {seen[a], seen[b], seen[c]};
        const Weights weights = nearest_on_triangle(corners);
        const Vector point = mixture(corners, weights);
        if (const double distance = dot(point, point); distance < least) {
            least = distance;
            best = mixture({colours_[a], colours_[b], colours_[c]}, weights);
        }
    }
    return {static_cast<float>(best[0]), static_cast<float>(best[1]), static_cast<float>(best[2])};
}

}  // namespace ccdt
