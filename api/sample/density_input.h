// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <variant>
#include <vector>

#include "api/decode/decode.h"
#include "api/image/image_header.h"
#include "api/input/option_reader.h"
#include "api/run/estimate.h"
#include "api/run/options.h"
#include "core/base/result.h"
#include "core/ccdt/plane/ccdt.h"
#include "core/density/density.h"

namespace ccdt::api {

/// Grid of densities, stretched over the bounding box of the domain. The first row is at the smallest y.
struct DensityGrid {
    int width = 0;
    int height = 0;
    std::vector<double> values;  ///< [width * height], finite, >= 0
};

/// Densities of voxels, stretched over the bounding box of a domain in space.
struct VoxelGrid {
    std::array<std::size_t, 3> voxels{};  ///< number along x, y and z
    std::vector<double> values;           ///< [z][y][x] finite, >= 0
};

/// Picture of densities, stretched over the bounding box of the domain. The first row is at the top. Dark pixels are
/// dense.
struct DensityImage {
    ImageFile file;
};

/// Density of a request. None: uniform.
using DensityInput = std::variant<std::monostate, DensityGrid, DensityImage>;

/// Direction of y in a domain.
enum class YAxis { Up, Down };

/// Reads a list of densities in JSON. Errors: Malformed, with a JSON Pointer to the faulty value.
Result<std::vector<double>> read_densities(const Input& input);

/// Reads the member `density`: `{"width":w,"height":h,"values":[...]}` or `{"image":"<base64>"}`.
/// Errors: Malformed, with a JSON Pointer to the faulty value; those of read_embedded_image().
Result<DensityInput> read_density(const Input& input, const Limits& limits);

/// Reads the densities of voxels: `{"width":w,"height":h,"depth":d,"values":[...]}`. Errors: as read_density().
Result<VoxelGrid> read_grid(const Input& input, const Limits& limits);

/// Creates the density of a request.
/// @param y  determines which row of a picture is the first row of the density, which is at the smallest y
/// Errors: those of `decode` and of Density::grid, with a JSON Pointer.
Result<Density> make_density(const DensityInput& input, YAxis y, const Limits& limits, const Decode& decode,
                             const Control& control);

/// Estimates the decoding of a picture of densities.
Estimate decoding_cost(const DensityInput& input);

/// Returns the number of cells of a density; 0 if it is uniform.
double cells_of(const DensityInput& input);

/// Returns the number of bytes that a density holds in memory in addition to the body of its request.
std::size_t bytes_of(const DensityInput& input);

}  // namespace ccdt::api
