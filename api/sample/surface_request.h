// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <variant>
#include <vector>

#include "api/input/point_order.h"
#include "api/run/deadline.h"
#include "api/sample/surface_formats.h"
#include "api/surface/surface_header.h"
#include "core/surface/distribute.h"

namespace ccdt::api {

/// Densities that the mesh itself determines.
enum class SurfaceDensityKind { Uniform, Colour, Curvature };

/// Request to /sample for points on the surface of a mesh.
struct SurfaceRequest {
    SurfaceFile file;
    SurfaceOptions run;
    /// The vector has a density for each vertex of the triangles that read_surface() returns.
    std::variant<SurfaceDensityKind, std::vector<double>> density = SurfaceDensityKind::Uniform;
    std::optional<double> crease;         ///< angle above which an edge is a crease, radians; none: no creases
    PointOrder order = PointOrder::None;  ///< not Path
    OnStop on_deadline = OnStop::Error;
    const SurfacePointFormat* format = nullptr;  ///< never null in a parsed request
};

}  // namespace ccdt::api
