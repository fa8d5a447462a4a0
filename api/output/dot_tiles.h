// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <stop_token>

#include "api/output/body.h"
#include "api/output/point_set.h"

namespace ccdt::api {

/// Northernmost latitude of Web Mercator, in degrees; the southernmost one is opposite.
inline constexpr double kMaxLatitude = 85.0511;

/// Writes a map of dots as vector tiles (Mapbox Vector Tile 2.1) in an archive (PMTiles 3), for Web Mercator.
///
/// Each zoom shows four times as many dots as the one before, and all of its dots; the last one shows all dots. So the
/// number of dots for an area of the screen is the same at every zoom, and dots appear but never move. The dots of a
/// zoom are those of the lowest ranks of each class, so they are spread evenly, and every class has its share.
///
/// Tiles have one layer, `dots`, of a point for each dot. Its id is unique, and ascends with the rank. Its attributes
/// are `class`, if dots have classes, and the properties that dots carry.
///
/// @param points  longitudes and latitudes in degrees, within kMaxLatitude, with ranks; all zooms are those of
///                PointSet::tiles
///
/// The same points give the same bytes. A stop leaves the output incomplete. O(n log n), with 40 bytes a point besides
/// the output, which is kept in memory until its directory is known.
void write_dot_tiles(const PointSet& points, Body& body, const std::stop_token& stop);

}  // namespace ccdt::api
