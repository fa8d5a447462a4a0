// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "api/sample/spatial/point_format3.h"
#include "core/ccdt/surface/surface_note.h"
#include "core/ccdt/volume/box_domain3.h"
#include "core/ccdt/volume/distribute_volume.h"

namespace ccdt::api {

/// Points that are placed in space. They can be written in several formats.
struct PlacedVolume {
    VolumeDistribution dots;
    BoxDomain3 domain;  ///< not used for a solid
    Quality quality = Quality::Standard;
    std::uint64_t seed = 0;
    std::vector<SurfaceNote> repairs = {};   ///< of the mesh that bounds a solid
    std::vector<SurfaceNote> warnings = {};  ///< about this mesh
    double elapsed = 0;                      ///< computing time so far, milliseconds

    std::size_t size() const { return dots.points.size(); }
    std::vector<Column> columns() const { return {{"x", "x", "double"}, {"y", "y", "double"}, {"z", "z", "double"}}; }
    void read_row(std::size_t i, std::vector<double>& row) const {
        const Point3& p = dots.points[i];
        row.assign({p.x, p.y, p.z});
    }
};

/// Format of an answer with points in space.
///
/// JSON, CSV, NPY and PLY have the points as doubles. VTU is an unstructured grid of VTK (VTK XML, version 1.0) with
/// raw appended data: a vertex cell for each point, or the tetrahedra. MSH is Gmsh's binary format 4.1, for tetrahedra.
/// In VTU and MSH, tetrahedra of a torus are unwrapped(). Errors: Unusable if that is not possible ("format").
using VolumePointFormat = PointFormat3<PlacedVolume>;

/// Returns the formats, in the server's order of preference.
std::span<const VolumePointFormat* const> volume_formats();

}  // namespace ccdt::api
