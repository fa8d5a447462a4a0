// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "core/base/executor.h"
#include "core/ccdt/plane/narrow_rows.h"
#include "core/ccdt/surface/surface.h"
#include "core/ccdt/surface/surface_density.h"

namespace ccdt {

/// Finds the places where a surface is narrower than the spacing of sites, as on roads and ribbons, and evens out the
/// sites there. Does on a surface what even_out_narrow_places() (core/ccdt/plane/narrow_places.h) does in the plane;
/// creases count as borders.
class NarrowStrips {
public:
    /// @param surface   must outlive this object
    /// @param capacity  integral of the density that belongs to each site
    /// @param spacings  [vertices] wanted distance of neighbouring sites around each vertex of the surface, > 0
    /// @param sites     number of sites, which limits the number of triangles
    /// @param stop      polled regularly; after a stop the object must not be used
    ///
    /// O(n log n) for n = sites + faces.
    NarrowStrips(const Surface& surface, const SurfaceDensity& density, double capacity, std::vector<double> spacings,
                 std::size_t sites, Executor& executor, const std::stop_token& stop);

    /// Evens out the sites in narrow places. Sites whose strip is too near to another part of the surface to be told
    /// from it stay where they are.
    /// @param sites  sites in narrow places move
    /// @param stop   polled regularly; after a stop the sites must not be used
    /// @returns      whether each site moved [sites]; empty if none did
    ///
    /// O(n log n) for n = sites + faces.
    std::vector<std::uint8_t> even_out(std::span<SurfacePoint> sites, const std::stop_token& stop) const;

private:
    const Surface& surface_;
    std::vector<NarrowPiece<Point3>> pieces_;
};

}  // namespace ccdt
