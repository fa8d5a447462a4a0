// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace ccdt {

/// Smallest and largest diameters of printed spots, in pixels.
inline constexpr double kMinSpot = 1, kMaxSpot = 2;

/// Area that round spots of ink cover.
///
/// A dark pixel prints a disc around its centre. Areas of overlapping discs do not add up. A disc of a diameter of at
/// most 2 reaches the squares of the pixel and of its eight neighbours only. So the covered share of a pixel's square
/// is a function of these nine pixels.
class PrintedSpot {
public:
    /// A set of dark pixels among a pixel and its neighbours: the sum of their bits.
    using Neighbourhood = std::uint16_t;

    /// Marks a square outside the picture. Its covered share counts as 0.
    static constexpr Neighbourhood kOutside = 1U << 9;

    /// Returns the bit of a neighbour, or of the pixel itself.
    /// @param dx, dy  from -1 to 1
    static constexpr Neighbourhood bit(int dx, int dy) {
        return static_cast<Neighbourhood>(1U << static_cast<unsigned>(3 * (dy + 1) + dx + 1));
    }

    /// @param diameter  kMinSpot to kMaxSpot, in pixels
    explicit PrintedSpot(double diameter);

    /// Returns the covered share of a pixel's square.
    float share(Neighbourhood dark) const { return shares_[dark]; }

    /// Returns the covered share where all pixels are dark.
    float solid() const { return shares_[kOutside - 1]; }

private:
    std::array<float, 2 * kOutside> shares_{};
};

}  // namespace ccdt
