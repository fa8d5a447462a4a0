// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "api/sample/spatial/point_format3.h"
#include "api/sample/spatial/surface_files.h"

namespace ccdt::api {

/// Format of an answer with points on a surface.
using SurfacePointFormat = PointFormat3<PlacedSurface>;

/// Returns the formats, in the server's order of preference.
std::span<const SurfacePointFormat* const> surface_formats();

}  // namespace ccdt::api
