// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>

#include "api/input/point_order.h"
#include "api/run/deadline.h"
#include "api/sample/volume_formats.h"
#include "api/sample/voxel_input.h"
#include "api/surface/surface_header.h"
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

}  // namespace ccdt::api
