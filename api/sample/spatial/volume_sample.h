// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "api/decode/decode.h"
#include "api/json/json_document.h"
#include "api/run/options.h"
#include "api/sample/spatial/sample_request3.h"
#include "api/sample/spatial/volume_formats.h"
#include "api/sample/spatial/voxel_input.h"
#include "api/surface/surface_header.h"
#include "core/base/result.h"
#include "core/ccdt/plane/ccdt.h"
#include "core/ccdt/volume/box_domain3.h"
#include "core/ccdt/volume/distribute_volume.h"

namespace ccdt::api {

/// Request to /sample for points in space. Without `crease`, the angle is Solid::kCrease.
struct VolumeRequest : SampleRequest3<VolumeOptions, PlacedVolume> {
    static std::span<const VolumePointFormat* const> formats() { return volume_formats(); }

    BoxDomain3 domain;                 ///< box or torus; not used for a solid
    std::optional<SurfaceFile> solid;  ///< mesh that bounds the domain
    VoxelInput density;
};

/// Returns the names of the options.
std::vector<std::string_view> volume_options();

/// Whether a JSON body requests points in space: its domain is a box, has a depth, or is a word. The domain of a mask
/// may have a depth, too, but does not count.
bool asks_for_volume(JsonValue root);

/// Whether options beside a mesh request points inside it instead of points on its surface.
bool asks_for_solid(const std::vector<TextOption>& options);

/// Reads a request for points in space, whose options are the members of a JSON object.
///
/// @param options  must be empty
/// @param accept   the Accept header, empty if there is none; the option `format` takes precedence
/// Errors: Malformed for an unknown or repeated option, for a value of the wrong type or out of range, for missing
/// options, for a format of meshes without `mesh`, and for the quality stealthy unless the domain is a torus of uniform
/// density without fixed points; those of read_voxels() and check_volume(); LimitExceeded for too many sites or fixed
/// points; NotAcceptable if the client accepts none of the formats. Error::field is a JSON Pointer.
Result<VolumeRequest> parse_volume(JsonValue root, const std::vector<TextOption>& options, std::string_view accept,
                                   const Limits& limits);

/// Reads a request whose options are given as text.
/// @param voxels  the density; without `width`, `height` or `depth`, a voxel is one unit long
/// Errors: as above; Error::field begins with the name of an option.
Result<VolumeRequest> parse_volume(Result<VoxelInput> voxels, const std::vector<TextOption>& options,
                                   std::string_view accept, const Limits& limits);

/// Reads a request for points inside a mesh.
/// @param mesh  the mesh, or the error of its header
Result<VolumeRequest> parse_solid(Result<SurfaceFile> mesh, const std::vector<TextOption>& options,
                                  std::string_view accept, const Limits& limits);

/// Creates the domain and the density, and distributes points. run_sample3() also writes them.
///
/// Errors: those of `decode`; for a TIFF, those of VoxelDensity::create(), and Malformed for the quality stealthy
/// unless the density is uniform; for a solid, those of Surface::create(), Solid::create() and distribute_in_solid();
/// Stopped, unless points are already placed and the request accepts a partial result.
Result<PlacedVolume> place_sample3(const VolumeRequest& request, const Decode& decode, const Control& control,
                                   Timings& timings);

/// Estimates the cost of computing an answer, before voxels or a mesh are read.
Cost cost_of(const VolumeRequest& request);

/// Returns the size of a parsed request in bytes, without the body from which it was read.
std::size_t size_of(const VolumeRequest& request);

}  // namespace ccdt::api
