// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/spatial/voxel_input.h"

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "api/image/image_header.h"
#include "api/json/json_document.h"
#include "api/output/stage_costs.h"
#include "api/text/text.h"

namespace ccdt::api {
namespace {

Result<VoxelInput> open_npy(std::string_view bytes) {
    const auto array = read_npy(bytes);
    if (!array) return tl::unexpected(array.error());
    const auto& shape = array->shape;
    if (shape.size() != 3 || std::ranges::min(shape) == 0) {
        std::string sides;
        for (const std::size_t side : shape) sides += (sides.empty() ? "" : ", ") + std::to_string(side);
        return failure(ErrorCode::Malformed,
                       "the NPY file must be an array of the shape (depth, height, width), each at least 1, not (" +
                           excerpt(sides) + ")");
    }
    if (!array->has_numbers())
        return failure(ErrorCode::Malformed,
                       "the NPY file must have booleans, integers or floats of 1 to 8 bytes, not the type '" +
                           excerpt(array->type) + "'");
    return VoxelInput{{{shape[2], shape[1], shape[0]}, {}}, bytes};
}

Result<VoxelInput> open_tiff(std::string_view bytes, const Limits& limits) {
    return read_image_header(bytes, limits.max_pixels).map([&](const ImageHeader& header) {
        const auto size = [](std::uint64_t value) { return static_cast<std::size_t>(value); };
        return VoxelInput{{{size(header.width), size(header.height), size(header.frames)}, {}},
                          bytes,
                          size(header.decoder_bytes),
                          std::nullopt};
    });
}

/// Checks the values of voxels, unless they are in a TIFF.
Result<VoxelInput> checked(VoxelInput input) {
    if (input.is_tiff()) return input;
    const auto array = input.file.empty() ? NpyArray() : *read_npy(input.file);
    auto uniform = input.file.empty()
                       ? VoxelDensity::check(input.voxels, [&](std::size_t i) { return input.values[i]; })
                       : VoxelDensity::check(input.voxels, [&](std::size_t i) { return array.value(i); });
    if (!uniform) return tl::unexpected(std::move(uniform.error()));
    input.is_uniform = *uniform;
    return input;
}

Result<std::vector<double>> read_values(const VoxelInput& input, const Decode& decode, const std::stop_token& stop) {
    if (!input.is_tiff()) {
        std::vector<double> values(static_cast<std::size_t>(input.count()));
        const NpyArray array = *read_npy(input.file);
        for (std::size_t i = 0; i < values.size(); ++i) values[i] = array.value(i);
        return values;
    }
    Reading reading(static_cast<std::size_t>(input.count()));
    reading.is_stack = true;
    return decode.grey(input.file, reading, stop).map([](const Picture& stack) {
        return std::vector<double>(stack.luminance.begin(), stack.luminance.end());
    });
}

}  // namespace

bool is_voxel_file(std::string_view bytes) {
    const auto format = recognise_image(bytes);
    return is_npy(bytes) || (format && *format == ImageFormat::Tiff);
}

Result<VoxelInput> open_voxels(std::string_view bytes, const Limits& limits) {
    auto input = is_npy(bytes) ? open_npy(bytes) : open_tiff(bytes, limits);
    if (input && input->count() > static_cast<double>(limits.max_pixels))
        return failure(ErrorCode::LimitExceeded,
                       "there are " + std::to_string(static_cast<std::uint64_t>(input->count())) +
                           " voxels; this server's limit (max-pixels) is " + std::to_string(limits.max_pixels));
    return std::move(input).and_then(checked);
}

Result<VoxelInput> read_voxels(const Input& input, const Limits& limits) {
    const auto* text = std::get_if<std::string_view>(&input.value);
    if (text == nullptr)
        return read_grid(input, limits).and_then([](VoxelGrid grid) { return checked({std::move(grid)}); });
    if (trim(*text).starts_with('{'))
        return parse_json(input).and_then([&](const JsonDocument& document) {
            return read_voxels({"/density", "/density", document.root()}, limits);
        });
    if (!is_voxel_file(*text)) return malformed(input, "must be an NPY file, a TIFF, or an object in JSON");
    const auto owned = std::make_shared<const std::string>(*text);
    auto voxels = open_voxels(*owned, limits);
    if (voxels) {
        voxels->owned = owned;
    } else if (voxels.error().field.empty()) {
        voxels.error().field = input.field;
    }
    return voxels;
}

Result<VoxelDensity> make_density(const VoxelInput& input, const Decode& decode, const std::stop_token& stop) {
    if (input.is_uniform.value_or(false)) return VoxelDensity::uniform();
    if (input.file.empty()) return VoxelDensity::create(input.voxels, input.values);
    const auto values = read_values(input, decode, stop);
    if (!values) return failure(values.error().code, values.error().message, "density");
    return VoxelDensity::create(input.voxels, *values);
}

Estimate voxel_cost(const VoxelInput& input) {
    if (input.is_uniform.value_or(false)) return {};
    const auto [x, y, z] = input.voxels;
    const double count = input.count();
    const double corners = (static_cast<double>(x) + 1) * (static_cast<double>(y) + 1) * (static_cast<double>(z) + 1);
    // A double and a bit for each voxel, later a float, and a double for the sum of masses up to each corner. A TIFF
    // needs a float, too.
    constexpr Estimate kVoxel{9, 0.03 * kMicrosecond}, kCorner{8, 0}, kOfTiff{4, 0.03 * kMicrosecond};
    const Estimate read = kVoxel * count + kCorner * corners + zones_cost(count);
    if (!input.is_tiff()) return read;
    return read + kOfTiff * count + Estimate{static_cast<double>(input.decoder_bytes + input.file.size()), 0};
}

std::size_t bytes_of(const VoxelInput& input) {
    return input.values.size() * sizeof(double) + (input.owned ? input.owned->size() : 0);
}

}  // namespace ccdt::api
