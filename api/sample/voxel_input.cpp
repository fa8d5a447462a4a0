// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/voxel_input.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "api/image/image_header.h"
#include "api/input/npy_reader.h"
#include "api/json/json_document.h"
#include "api/text/text.h"

namespace ccdt::api {
namespace {

template <class Element>
std::vector<double> values_of(std::string_view data) {
    std::vector<double> values(data.size() / sizeof(Element));
    for (std::size_t i = 0; i < values.size(); ++i) {
        Element element;
        std::memcpy(&element, data.data() + i * sizeof(Element), sizeof(Element));
        values[i] = static_cast<double>(element);
    }
    return values;
}

/// A type of elements in NumPy's notation, and the function that converts them.
struct ElementType {
    std::string_view name;
    std::vector<double> (*values_of)(std::string_view data);
};

constexpr ElementType kTypes[] = {
    {"|b1", values_of<std::uint8_t>},  {"|u1", values_of<std::uint8_t>},  {"|i1", values_of<std::int8_t>},
    {"<u2", values_of<std::uint16_t>}, {"<i2", values_of<std::int16_t>},  {"<u4", values_of<std::uint32_t>},
    {"<i4", values_of<std::int32_t>},  {"<u8", values_of<std::uint64_t>}, {"<i8", values_of<std::int64_t>},
    {"<f4", values_of<float>},         {"<f8", values_of<double>},
};

const ElementType* find_type(std::string_view name) {
    const auto* const found = std::ranges::find(kTypes, name, &ElementType::name);
    return found == std::end(kTypes) ? nullptr : found;
}

Result<VoxelFile> open_npy(std::string_view bytes) {
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
    if (find_type(array->type) == nullptr)
        return failure(ErrorCode::Malformed,
                       "the NPY file must have little-endian integers or floats of 1 to 8 bytes, not the type '" +
                           excerpt(array->type) + "'");
    return VoxelFile{bytes, {shape[2], shape[1], shape[0]}};
}

Result<VoxelFile> open_tiff(std::string_view bytes, const Limits& limits) {
    return read_image_header(bytes, limits.max_pixels).map([&](const ImageHeader& header) {
        return VoxelFile{bytes, {header.width, header.height, header.frames}, header.decoder_bytes};
    });
}

Result<std::vector<double>> read_values(const VoxelFile& file, const Decode& decode, const std::stop_token& stop) {
    if (is_npy(file.bytes))
        return read_npy(file.bytes).map([](const NpyArray& array) {
            return find_type(array.type)->values_of(array.data);
        });
    Reading reading(static_cast<std::size_t>(file.count()));
    reading.is_stack = true;
    return decode.grey(file.bytes, reading, stop).map([](const Picture& stack) {
        return std::vector<double>(stack.luminance.begin(), stack.luminance.end());
    });
}

}  // namespace

bool is_voxel_file(std::string_view bytes) {
    const auto format = recognise_image(bytes);
    return is_npy(bytes) || (format && *format == ImageFormat::Tiff);
}

Result<VoxelFile> open_voxels(std::string_view bytes, const Limits& limits) {
    auto file = is_npy(bytes) ? open_npy(bytes) : open_tiff(bytes, limits);
    if (file && file->count() > static_cast<double>(limits.max_pixels))
        return failure(ErrorCode::LimitExceeded,
                       "there are " + std::to_string(static_cast<std::uint64_t>(file->count())) +
                           " voxels; this server's limit (max-pixels) is " + std::to_string(limits.max_pixels));
    return file;
}

Result<VoxelInput> read_voxels(const Input& input, const Limits& limits) {
    const auto* text = std::get_if<std::string_view>(&input.value);
    if (text == nullptr)
        return read_grid(input, limits).map([](VoxelGrid grid) { return VoxelInput(std::move(grid)); });
    if (trim(*text).starts_with('{')) {
        const auto document = JsonDocument::parse(*text);
        if (!document) return malformed(input, "must be valid JSON: " + document.error().message);
        return read_voxels({"/density", "/density", document->root()}, limits);
    }
    if (!is_voxel_file(*text)) return malformed(input, "must be an NPY file, a TIFF, or an object in JSON");
    const auto owned = std::make_shared<const std::string>(*text);
    auto file = open_voxels(*owned, limits);
    if (!file) return failure(file.error().code, file.error().message, input.field);
    file->owned = owned;
    return *std::move(file);
}

Result<VoxelDensity> make_density(const VoxelInput& input, const Decode& decode, const std::stop_token& stop) {
    if (const auto* file = std::get_if<VoxelFile>(&input)) {
        const auto values = read_values(*file, decode, stop);
        if (!values) return failure(values.error().code, values.error().message, "density");
        return VoxelDensity::create(file->voxels, *values);
    }
    const auto* grid = std::get_if<VoxelGrid>(&input);
    if (grid == nullptr) return VoxelDensity::uniform();
    return VoxelDensity::create(grid->voxels, grid->values);
}

std::optional<std::array<std::size_t, 3>> voxels_of(const VoxelInput& input) {
    if (const auto* grid = std::get_if<VoxelGrid>(&input)) return grid->voxels;
    if (const auto* file = std::get_if<VoxelFile>(&input)) return file->voxels;
    return std::nullopt;
}

Estimate voxel_cost(const VoxelInput& input) {
    const auto voxels = voxels_of(input);
    if (!voxels) return {};
    const auto [x, y, z] = *voxels;
    const double count = static_cast<double>(x) * static_cast<double>(y) * static_cast<double>(z);
    const double corners = (static_cast<double>(x) + 1) * (static_cast<double>(y) + 1) * (static_cast<double>(z) + 1);
    // A double and a bit for each voxel, and a double for the sum of masses up to each corner. A TIFF needs a float,
    // too.
    constexpr Estimate kVoxel{9, 0.03 * kMicrosecond}, kCorner{8, 0}, kOfTiff{4, 0.03 * kMicrosecond};
    const Estimate read = kVoxel * count + kCorner * corners;
    const auto* file = std::get_if<VoxelFile>(&input);
    if (file == nullptr || file->decoder_bytes == 0) return read;
    return read + kOfTiff * count + Estimate{static_cast<double>(file->decoder_bytes + file->bytes.size()), 0};
}

std::size_t bytes_of(const VoxelInput& input) {
    if (const auto* grid = std::get_if<VoxelGrid>(&input)) return grid->values.size() * sizeof(double);
    const auto* file = std::get_if<VoxelFile>(&input);
    return file != nullptr && file->owned ? file->owned->size() : 0;
}

}  // namespace ccdt::api
