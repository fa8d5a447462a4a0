// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/surface/surface_note.h"
#include "core/volume/box_domain3.h"
#include "core/volume/distribute_volume.h"

namespace ccdt::api {

/// Points that are placed in space. They can be written in several formats.
struct PlacedVolume {
    VolumeDistribution dots;
    BoxDomain3 domain;  ///< of a solid, its bounding box
    Quality quality = Quality::Standard;
    std::uint64_t seed = 0;
    std::vector<SurfaceNote> repairs = {};   ///< of the mesh that bounds a solid
    std::vector<SurfaceNote> warnings = {};  ///< about this mesh
    double elapsed = 0;                      ///< computing time so far, milliseconds

    std::size_t size() const { return dots.points.size(); }
};

}  // namespace ccdt::api
