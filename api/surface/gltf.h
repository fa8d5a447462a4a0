// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "api/surface/gltf_document.h"
#include "api/surface/gltf_materials.h"
#include "api/surface/surface_builder.h"
#include "api/surface/surface_format.h"
#include "core/base/result.h"

namespace ccdt::api {

/// Determines the size of the scene of a glTF. Errors: Unusable if its nodes do not form a tree. Time: linear in the
/// size of the JSON.
Result<SurfaceSize> measure_gltf(const GltfDocument& gltf);

/// Reads the scene of a glTF; without scenes, all root nodes. Meshes are in the order in which nodes refer to them,
/// parents first, with the transformations of the nodes. A mesh with a skin is in the pose that the nodes of its joints
/// have in the file. Morph targets are applied with the weights in the file. Points and lines are ignored, with a
/// warning.
/// @param decode  decoder of pictures; empty: they are not read
/// Errors: Unusable for damaged meshes.
/// Source: glTF 2.0 (ISO/IEC 12113), 3.5, 3.7, and the extensions KHR_mesh_quantization and KHR_texture_transform.
Result<SurfaceContents> read_gltf(const GltfDocument& gltf, const SurfaceHeader& header, const SurfaceSize& size,
                                  const DecodePicture& decode);

}  // namespace ccdt::api
