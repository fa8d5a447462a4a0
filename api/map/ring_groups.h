// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/geometry/domain.h"

namespace ccdt::api {

/// Groups the rings of one shape into polygons. Clockwise rings, with y up, are outer rings; counter-clockwise ones are
/// holes. A hole belongs to the smallest outer ring that contains it; one that no outer ring contains is an outer ring
/// itself. Rings without an area are outer rings.
///
/// @returns  indices of the rings of each polygon, the outer ring first; polygons and holes in the order of the rings
///
/// A hole whose box lies in the box of only one outer ring is given to that ring without further tests.
/// O(corners + rings * sqrt(outer rings)) where rings are small beside the shape; besides O(corners of the ring) for
/// each of several rings whose box contains a hole. Source: ESRI Shapefile Technical Description, 1998, page 8.
std::vector<std::vector<std::size_t>> group_rings(std::span<const Ring> rings);

}  // namespace ccdt::api
