// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>

#include "api/surface/obj.h"
#include "api/surface/off.h"
#include "api/surface/ply.h"
#include "api/surface/stl.h"
#include "api/surface/surface_format.h"
#include "core/base/result.h"

namespace ccdt::api {

/// Reads a mesh file that is not a glTF.
/// @param sink  SurfaceCounter or SurfaceBuilder
/// Errors: those of the reader of the format.
template <class Sink>
Result<void> read_plain_format(std::string_view bytes, SurfaceFormat format, Sink& sink) {
    if (format == SurfaceFormat::StlText) return read_text_stl(bytes, sink);
    if (format == SurfaceFormat::StlBinary) return read_binary_stl(bytes, sink);
    if (format == SurfaceFormat::Obj) return read_obj(bytes, sink);
    return format == SurfaceFormat::Ply ? read_ply(bytes, sink) : read_off(bytes, sink);
}

}  // namespace ccdt::api
