// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <vector>

#include "api/input/palette.h"
#include "api/output/formats.h"
#include "api/output/map_figure.h"
#include "api/sample/plane/sample_area.h"
#include "api/sample/plane/sample_request.h"
#include "core/ccdt/globe/map_projection.h"
#include "core/geometry/point.h"

namespace ccdt::api {

/// Plane in which the points of a sample are drawn.
struct SampleDrawing {
    std::optional<MapProjection> projection;  ///< of longitudes and latitudes; none: points are drawn as they are
    Box box;                                  ///< that the drawing shows
    double pitch = 0;                         ///< distance of neighbouring points in the plane
    std::optional<MapFigure> figure;          ///< outlines and legend; none: the drawing has points only

    /// Maps points to the plane.
    std::vector<Point> place(std::vector<Point> points) const;
};

/// Returns the inks of the classes, or a single black ink without a name if answers do not name classes.
Palette palette_of(const SampleRequest& request);

/// Whether a format draws maps: shapes that are filled, or pixels, in one file.
bool can_draw_maps(const PointFormat& format, const DrawingOptions& drawing);

/// Plans the drawing of a sample. Longitudes and latitudes are drawn on an equal-area map, whose unit is a degree of a
/// great circle. By default, dot maps on the globe have outlines and a legend. A legend lies in a corner that is free
/// of features, or else below the map. In a dot map with a figure or on the globe, the pitch is that of dense places:
/// nine tenths of the dots are in features where dots are farther apart. It is at least a thousandth of the longer
/// side.
///
/// @param format  of the answer; need not draw
SampleDrawing plan_drawing(const SampleRequest& request, const PointFormat& format, const SampleArea& area);

}  // namespace ccdt::api
