// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>

#include "core/base/executor.h"
#include "core/ccdt/polish/octave_transport.h"
#include "core/ccdt/volume/box_domain3.h"
#include "core/ccdt/volume/volume_spacing.h"
#include "core/ccdt/volume/voxel_density.h"
#include "core/geometry/point3.h"

namespace ccdt {

/// Prepares the transport of points in space. Unlike in the plane, the filter for a uniform density is sharp, which
/// leaves larger distances between points.
/// @param box      bounding box of the domain
/// @param volume   of the domain
/// @param density  over the bounding box; in a solid, 0 outside
/// @param points   number of sites and fixed points
/// @param precise  whether the grid is precise enough to reduce power to -100 dB, which takes more than twice the
///                 memory
/// @param stop     polled regularly; after a stop, the transport must not be used
OctaveTransport<Point3> volume_transport(const BoxDomain3& box, double volume, const VoxelDensity& density,
                                         const VolumeSpacing& spacing, std::size_t points, bool precise,
                                         Executor& executor, const std::stop_token& stop = {});

}  // namespace ccdt
