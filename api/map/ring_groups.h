// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "core/geometry/domain.h"

namespace ccdt::api {

/// Groups the rings of one shape into polygons. Clockwise rings, with y up, are outer rings; counter-clockwise ones are
/// holes. A hole belongs to the smallest outer ring that contains it. A hole that no outer ring contains becomes an
/// outer ring. Rings without an area are outer rings.
///
/// @returns  for each polygon the indices of its rings, the outer ring first; polygons, and holes within a polygon,
///           keep the order of the rings
///
/// Rings may touch, but should not cross. A ring contains a hole if it has at least the hole's area and contains a
/// point inside the hole. O(corners * log corners), plus the number of edges of outer rings at the height of each hole.
/// Source: ESRI Shapefile Technical Description, 1998, page 8.
std::vector<std::vector<std::size_t>> group_rings(std::span<const Ring> rings);

}  // namespace ccdt::api
