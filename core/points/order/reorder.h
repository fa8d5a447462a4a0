// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>

#include "core/ccdt/plane/ccdt.h"
#include "core/ccdt/surface/distribute.h"
#include "core/ccdt/volume/distribute_volume.h"

namespace ccdt {

/// Reorders the points of a distribution, together with its mesh, if any.
/// @param order  [points] for each position, the index of the point that moves there: a permutation
void reorder(Distribution& distribution, std::span<const std::uint32_t> order);
void reorder(SurfaceDistribution& distribution, std::span<const std::uint32_t> order);
void reorder(VolumeDistribution& distribution, std::span<const std::uint32_t> order);

}  // namespace ccdt
