// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <stop_token>

namespace ccdt {

/// Calls use(centre) for each of the side^2 congruent triangles into which a face can be divided, in rows.
/// @tparam Use  function of the barycentric coordinates of the triangle's centre
/// @param stop  polled once per row
template <class Use>
void for_face_pieces(std::uint32_t side, Use use, const std::stop_token& stop = {}) {
    for (std::uint32_t row = 0; row < side && !stop.stop_requested(); ++row) {
        // Every other triangle of a row is upside down.
        for (std::uint32_t k = 0; k < 2 * (side - row) - 1; ++k) {
            const double third = k % 2 == 0 ? 1.0 / 3 : 2.0 / 3;
            const double u = (k / 2 + third) / side, v = (row + third) / side;
            use(std::array{1 - u - v, u, v});
        }
    }
}

/// Steps of the additive recurrence of the plastic number: the fractional parts of (k kFirstStep, k kSecondStep) are
/// spread evenly over the unit square.
/// Source: Roberts 2018, "The unreasonable effectiveness of quasirandom sequences".
inline constexpr double kFirstStep = 0.7548776662466927, kSecondStep = 0.5698402909980532;

/// Maps a position in the unit square to a position in a triangle, given by barycentric coordinates. Keeps ratios of
/// areas.
inline std::array<double, 3> position_in_triangle(double u, double v) {
    if (u + v > 1) return {u + v - 1, 1 - u, 1 - v};
    return {1 - u - v, u, v};
}

}  // namespace ccdt
