// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <stop_token>

#include "core/base/executor.h"
#include "core/ccdt/volume/volume_spacing.h"
#include "core/geometry/point3.h"

namespace ccdt {

/// Moves near sites apart. In a box or solid, the mirror images of sites push, too, which keeps the first layer about
/// half a spacing off the border. Coincident sites move apart, each in a direction of its own.
/// @tparam Domain   BoxDomain3 or SolidDomain
/// @param sites     [sites + fixed] in the domain; the first `free` of them move
/// @param reach     distance below which two sites are pushed, relative to the distance of neighbours in the densest
///                  packing with the local density
/// @param share     share of the missing distance by which each of two sites moves; a move is at most half the reach
/// @param stop      polled regularly; a stop leaves the sites where they are
/// @returns         the least distance between two sites before the push, relative to the densest packing; `reach` if
///                  all distances are larger; meaningless after a stop
///
/// The result does not depend on the number of threads. O(sites).
template <class Domain>
double push_apart(const Domain& domain, const VolumeSpacing& spacing, std::span<Point3> sites, std::size_t free,
                  double reach, double share, Executor& executor, const std::stop_token& stop);

}  // namespace ccdt
