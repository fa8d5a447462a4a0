// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>

#include "api/decode/decode.h"
#include "api/input/npy_reader.h"
#include "api/input/option_reader.h"
#include "api/run/estimate.h"
#include "api/run/options.h"
#include "api/sample/density_input.h"
#include "core/base/result.h"
#include "core/ccdt/volume/voxel_density.h"

namespace ccdt::api {

/// Density of a request for points in space: voxels or, without any, uniform.
///
/// Voxels are values in JSON or a file: a NumPy array (depth, height, width), or a TIFF with a page for each layer,
/// from the smallest z. The first row of a layer is at the smallest y. The values are the densities.
struct VoxelInput : VoxelGrid {
    std::string_view file = {};     ///< lies in `owned` or in the caller's memory; empty: `values` has the densities
    std::size_t decoder_bytes = 0;  ///< memory of the reader of a TIFF; 0 for a NumPy array
    std::optional<bool> is_uniform = true;  ///< whether all densities are equal; none: unknown until a TIFF is read
    std::shared_ptr<const std::string> owned = {};

    bool is_tiff() const { return !file.empty() && !is_npy(file); }
    double count() const {
        return static_cast<double>(voxels[0]) * static_cast<double>(voxels[1]) * static_cast<double>(voxels[2]);
    }
};

/// Whether a file may have voxels, by its first bytes.
bool is_voxel_file(std::string_view bytes);

/// Reads the header of a file of voxels, and checks the values of a NumPy array.
/// Errors: those of read_npy() and read_image_header(), Malformed for an array without three axes, or of a type that is
/// not supported, and LimitExceeded for more than limits.max_pixels voxels, with an empty Error::field; those of
/// VoxelDensity::check().
Result<VoxelInput> open_voxels(std::string_view bytes, const Limits& limits);

/// Reads the option `density`: `{"width":w,"height":h,"depth":d,"values":[...]}`, or the text of a file of voxels.
/// Errors: Malformed, with a JSON Pointer to the faulty value; those of open_voxels() and VoxelDensity::check().
Result<VoxelInput> read_voxels(const Input& input, const Limits& limits);

/// Creates the density of a request. Errors: those of `decode` and of VoxelDensity::create().
Result<VoxelDensity> make_density(const VoxelInput& input, const Decode& decode, const std::stop_token& stop);

/// Estimates the cost of reading voxels and of creating the density.
Estimate voxel_cost(const VoxelInput& input);

/// Returns the number of bytes that voxels hold in memory in addition to the body of their request.
std::size_t bytes_of(const VoxelInput& input);

}  // namespace ccdt::api
