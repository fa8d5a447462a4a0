// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>
#include <vector>

#include "api/json/json_document.h"
#include "api/run/options.h"
#include "api/sample/volume_request.h"
#include "core/result.h"

namespace ccdt::api {

/// Returns the names of the options.
std::vector<std::string_view> volume_options();

/// Whether a JSON body requests points in space: its domain is a box, or has a depth. Masks with a depth are no points.
bool asks_for_volume(JsonValue root);

/// Whether options beside a mesh request points inside it instead of points on its surface.
bool asks_for_solid(const std::vector<TextOption>& options);

/// Reads a request for points in space, whose options are the members of a JSON object.
///
/// @param options  must be empty
/// @param accept   the Accept header, empty if there is none; the option `format` takes precedence
/// Errors: Malformed for an unknown or repeated option, for a value of the wrong type or out of range, for missing
/// options, for a format of meshes without `mesh`, and for the quality stealthy unless the domain is a torus of uniform
/// density without fixed points; those of open_voxels(); LimitExceeded for too many sites or fixed points;
/// NotAcceptable if the client accepts none of the formats. Error::field is a JSON Pointer.
Result<VolumeRequest> parse_volume(JsonValue root, const std::vector<TextOption>& options, std::string_view accept,
                                   const Limits& limits);

/// Reads a request whose options are given as text.
/// @param voxels   the density; without `width`, `height` or `depth`, a voxel is one unit long
/// Errors: as above; Error::field begins with the name of an option.
Result<VolumeRequest> parse_volume(Result<VoxelFile> voxels, const std::vector<TextOption>& options,
                                   std::string_view accept, const Limits& limits);

/// Reads a request for points inside a mesh.
/// @param mesh  the mesh, or the error of its header
Result<VolumeRequest> parse_solid(Result<SurfaceFile> mesh, const std::vector<TextOption>& options,
                                  std::string_view accept, const Limits& limits);

}  // namespace ccdt::api
