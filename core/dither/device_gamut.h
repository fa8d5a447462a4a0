// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "core/halftone/colour_difference.h"
#include "core/halftone/overprint.h"

namespace ccdt {

/// The colours that mixtures of a device's colours can make: the convex hull of these colours in linear light.
class DeviceGamut {
public:
    /// @param colours  at least 2 different colours in linear light
    explicit DeviceGamut(std::span<const Light> colours);

    /// Returns the colour of the gamut that looks most like a given one. A colour within the gamut is returned
    /// unchanged, except for rounding.
    ///
    /// The distance is that in CIELAB, linearised at the given colour. Continuous. O(facets), of which there are at
    /// most twice as many as colours, or, for flat gamuts, O(colours^3).
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
    std::vector<Facet> facets_;  ///< if the hull is flat, all triangles
    bool is_flat_ = false;       ///< whether the hull has no volume
};

}  // namespace ccdt
