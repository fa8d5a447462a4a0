// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "core/halftone/inks/overprint.h"
#include "core/picture/colour_difference.h"

namespace ccdt {

/// Gamut of a device: the convex hull of its colours in linear light, which contains all mixtures of these colours.
class DeviceGamut {
public:
    /// @param colours  at least 2 different colours in linear light
    explicit DeviceGamut(std::span<const Light> colours);

    /// Returns the colour of the gamut that looks most like a given colour. Colours within the gamut hardly change.
    ///
    /// Minimises the distance in CIELAB, linearised at the given colour. The result is continuous in `light`.
    /// O(facets): at most two facets per colour, or O(colours^3) if the gamut is flat.
    Light nearest(const Light& light) const;

private:
    using Vector = Lab;

    /// A triangle between three of the colours.
    struct Facet {
        std::array<std::size_t, 3> corners{};
        Vector outwards{};  ///< normal
    };

    bool contains(const Vector& light) const;

    std::vector<Vector> colours_;
    std::vector<Facet> facets_;  ///< faces of the hull; if the hull is flat, all triangles between colours
    bool is_flat_ = false;       ///< whether the hull has no volume
};

}  // namespace ccdt
