// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <span>
#include <string_view>
#include <variant>
#include <vector>

#include "api/decode/decode.h"
#include "api/run/options.h"
#include "api/sample/spatial/sample_request3.h"
#include "api/sample/spatial/surface_formats.h"
#include "api/surface/surface_header.h"
#include "core/base/result.h"
#include "core/ccdt/plane/ccdt.h"
#include "core/ccdt/surface/distribute.h"

namespace ccdt::api {

/// Densities that the mesh itself determines.
enum class SurfaceDensityKind { Uniform, Colour, Curvature };

/// Request to /sample for points on the surface of a mesh. Without `crease`, there are no creases.
struct SurfaceRequest : SampleRequest3<SurfaceOptions, PlacedSurface> {
    static std::span<const SurfacePointFormat* const> formats() { return surface_formats(); }

    SurfaceFile file;
    /// The vector has a density for each vertex of the triangles that read_surface() returns.
    std::variant<SurfaceDensityKind, std::vector<double>> density = SurfaceDensityKind::Uniform;
};

/// Returns the names of the options.
std::vector<std::string_view> surface_options();

/// Reads a request for points on a surface.
///
/// @param file     the mesh, or the error of its header
/// @param options  options in the order of the request
/// @param accept   the Accept header, empty if there is none; the option `format` takes precedence
/// Errors: those of `file`; Malformed for an unknown or repeated option, for a value out of range, if `sites` is
/// missing, and for a format of meshes without `mesh`; Unusable for a list of densities without a number above 0;
/// LimitExceeded for too many sites or fixed points; NotAcceptable if the client accepts none of the formats.
/// Error::field is the name of an option; for a list, the index of the faulty element follows: `density/3`.
Result<SurfaceRequest> parse_surface(Result<SurfaceFile> file, const std::vector<TextOption>& options,
                                     std::string_view accept, const Limits& limits);

/// Reads the mesh, makes a surface of its triangles, and distributes points on it. run_sample3() also writes them.
///
/// Errors: those of `decode` and Surface::create(); Unusable if the density is zero everywhere, and if it follows the
/// colours of a mesh without colours; Malformed if the number of densities is not that of the vertices; Stopped, unless
/// points are already placed and the request accepts a partial result.
Result<PlacedSurface> place_sample3(const SurfaceRequest& request, const Decode& decode, const Control& control,
                                    Timings& timings);

/// Estimates the cost of computing an answer, before the mesh is read.
Cost cost_of(const SurfaceRequest& request);

/// Returns the size of a parsed request in bytes, without the body from which it was read.
std::size_t size_of(const SurfaceRequest& request);

}  // namespace ccdt::api
