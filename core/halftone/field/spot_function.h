// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace ccdt {

/// The order in which ink fills the triangles between sites, from dots around the sites to holes at the centres.
///
/// The spot function has a value in [0, 1] at each position in a triangle, given by barycentric coordinates. Its values
/// are uniformly distributed: the positions where it exceeds 1 - c cover exactly the share c of every triangle,
/// whatever the triangle's shape, because barycentric coordinates keep ratios of areas. Its values along an edge do not
/// depend on the triangle's third corner, so contours continue from triangle to triangle.
///
/// Contours near the value 1 are circles around the corners, up to the deformation of the triangle. Contours near 0 are
/// circles around the centroid. Dots of neighbouring corners join at the value 0.407.
class SpotFunction {
public:
    SpotFunction();

    /// @param a, b, c  barycentric coordinates, >= 0, with the sum 1
    float operator()(float a, float b, float c) const {
        const float least = std::min(std::min(a, b), c), most = std::max(std::max(a, b), c);
        return at(2 * (1 - most - 2 * least), 3 * least);
    }

private:
    static constexpr std::size_t kSteps = 128;

    /// Interpolates in the sixth of the triangle that lies nearest to a corner and an edge.
    /// @param along   weight of the middle of the edge
    /// @param inside  weight of the centroid; the corner has the rest
    float at(float along, float inside) const {
        const float x = std::clamp(along, 0.0f, 1.0f) * kSteps, y = std::clamp(inside, 0.0f, 1.0f) * kSteps;
        const std::size_t column = std::min(static_cast<std::size_t>(x), kSteps - 1);
        const std::size_t row = std::min(static_cast<std::size_t>(y), kSteps - 1);
        const float right = x - static_cast<float>(column), down = y - static_cast<float>(row);
        const float* upper = values_.data() + row * (kSteps + 1) + column;
        const float* lower = upper + kSteps + 1;
        // Each square has two halves. Written so that compilers choose values without branches.
        const bool beyond = right + down > 1;
        const float corner = *(beyond ? lower + 1 : upper), next = *(beyond ? lower : upper + 1),
                    below = *(beyond ? upper + 1 : lower);
        const float to_next = beyond ? 1 - right : right, to_below = beyond ? 1 - down : down;
        return corner + to_next * (next - corner) + to_below * (below - corner);
    }

    std::vector<float> values_;  ///< [kSteps + 1][kSteps + 1] at steps of `inside` and `along`
};

}  // namespace ccdt
