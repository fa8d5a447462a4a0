// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "api/input/point_order.h"
#include "api/json/json_document.h"
#include "api/run/deadline.h"
#include "api/run/options.h"
#include "api/sample/volume_formats.h"
#include "api/sample/voxel_input.h"
#include "api/surface/surface_header.h"
#include "core/result.h"
#include "core/volume/box_domain3.h"
#include "core/volume/distribute_volume.h"

namespace ccdt::api {

/// Request to /sample for points in space.
struct VolumeRequest {
    BoxDomain3 domain;                 ///< box or torus; not used for a solid
    std::optional<SurfaceFile> solid;  ///< mesh that bounds the domain
    VoxelInput density;
    VolumeOptions run;
    PointOrder order = PointOrder::None;  ///< not Path
    OnStop on_deadline = OnStop::Error;
    const VolumePointFormat* format = nullptr;  ///< never null in a parsed request
    bool is_json = false;                       ///< whether options are members of a JSON body

    /// Converts an error about an option, such as `fixed/3`: if the body is JSON, Error::field becomes a JSON Pointer;
    /// otherwise it begins with the name of the option.
    Error located(Error error) const;
};

/// Returns the names of the options.
std::vector<std::string_view> volume_options();

/// Whether a JSON body requests points in space: its domain is a box, or has a depth. A mask with a depth does not.
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
