// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/capabilities.h"

#include <algorithm>
#include <array>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "api/analyze/analyze.h"
#include "api/halftone/device_picture.h"
#include "api/halftone/halftone.h"
#include "api/input/colour.h"
#include "api/input/device.h"
#include "api/input/method.h"
#include "api/output/formats.h"
#include "api/sample/choice/choice_formats.h"
#include "api/sample/choice/choice_parser.h"
#include "api/sample/pixels/pixel_sample.h"
#include "api/sample/plane/sample_parser.h"
#include "api/sample/spatial/surface_formats.h"
#include "api/sample/spatial/surface_sample.h"
#include "api/sample/spatial/volume_formats.h"
#include "api/sample/spatial/volume_sample.h"

namespace ccdt::api {
namespace {

using Json = nlohmann::ordered_json;

Json describe(const FileFormat& file) {
    return {{"name", file.name}, {"title", file.title}, {"media_type", file.media_type}, {"extension", file.extension}};
}

Json describe(const PointFormat& format) {
    Json json = describe(format.file);
    json["drawn"] = format.is_drawn();
    const RasterWriter* const pixels = format.raster();
    const bool any_side = pixels == nullptr || pixels->max_side == std::numeric_limits<int>::max();
    json["max_side"] = any_side ? Json() : Json(pixels->max_side);
    json["needs"] = Json::array();
    if (format.vector() != nullptr && format.vector()->in_millimetres) json["needs"].push_back("width_mm");
    if (format.is_tiled()) json["needs"].push_back("coordinates");
    return json;
}

/// Describes a row of a table of formats without further members for clients.
template <class Row>
Json describe(const Row& format) {
    return describe(format.file);
}

template <class Placed>
Json describe(const PointFormat3<Placed>& format) {
    Json json = describe(format.file);
    json["needs"] = Json::array();
    if (format.writer(false) == nullptr) json["needs"].push_back("mesh");
    return json;
}

std::vector<std::string> hexadecimal_of(std::span<const Colour> colours) {
    std::vector<std::string> list;
    list.reserve(colours.size());
    for (const Colour& colour : colours) list.push_back(hexadecimal(colour));
    return list;
}

Json describe_devices() {
    Json list = Json::array();
    for (const Device& device : devices()) {
        list.push_back({{"name", device.name},
                        {"title", device.title},
                        {"sent", hexadecimal_of(device.sent)},
                        {"seen", hexadecimal_of(device.seen)}});
    }
    return list;
}

template <class Row>
Json describe_all(std::span<const Row* const> formats) {
    Json list = Json::array();
    for (const Row* format : formats) list.push_back(describe(*format));
    return list;
}

/// Formats of maps that `/sample` reads. A decoding process first converts shapefiles to GeoJSON.
constexpr std::array<FileFormat, 3> kMaps = {{
    kGeoJson,
    {"topojson", "TopoJSON", "topojson", "application/json", ""},
    {"shapefile", "Shapefile, zipped", "zip", "application/zip", ""},
}};

/// Formats of meshes that `/sample` reads.
constexpr std::array<FileFormat, 6> kMeshes = {{
    {"stl", "STL", "stl", "model/stl", ""},
    {"obj", "Wavefront OBJ", "obj", "model/obj", ""},
    {"ply", "PLY", "ply", "model/ply", ""},
    {"off", "OFF", "off", "model/off", ""},
    {"gltf", "glTF with embedded buffers", "gltf", "model/gltf+json", ""},
    {"glb", "glTF, binary", "glb", "model/gltf-binary", ""},
}};

/// Formats of voxels that `/sample` reads.
constexpr std::array<FileFormat, 2> kVoxels = {{kNpy, {"tiff", "TIFF with several pages", "tif", "image/tiff", ""}}};

Json describe_all(std::span<const FileFormat> files) {
    Json list = Json::array();
    for (const FileFormat& file : files) list.push_back(describe(file));
    return list;
}

/// Returns the estimated seconds per site of each quality, for a density that is not uniform.
Json seconds_of(const Method& method) {
    Json seconds = Json::object();
    for (const auto& [word, quality] : qualities()) {
        Options options;
        options.sites = 1;
        options.iterations = method.iterations;
        options.quality = quality;
        seconds[std::string(word)] = method.cost(options, false).seconds;
    }
    return seconds;
}

Json describe(const Method& method, const Limits& limits) {
    return {{"name", method.name},
            {"title", method.title},
            {"max_sites", std::min(method.max_sites, limits.max_sites)},
            {"iterations", method.iterations},
            {"options", option_names(method)},
            {"seconds_per_site", seconds_of(method)}};
}

Json describe_methods(const Limits& limits) {
    Json list = Json::array();
    for (const Method& method : methods()) list.push_back(describe(method, limits));
    return list;
}

std::string_view name_of(OfferedPictures pictures) {
    switch (pictures) {
        case OfferedPictures::Unsigned:
            return "unsigned";
        case OfferedPictures::Signed:
            return "signed";
        case OfferedPictures::None:
            break;
    }
    return "none";
}

}  // namespace

std::string capabilities_json(const Limits& limits, OfferedPictures pictures, bool documentation,
                              const OfferedPresets& presets) {
    const Json document = {
        {"limits",
         {{"max_sites", limits.max_sites}, {"max_pixels", limits.max_pixels}, {"max_faces", limits.max_faces}}},
        {"halftone",
         {{"formats", describe_all(halftone_formats())},
          {"options", halftone_options()},
          {"devices",
           {{"types", describe_devices()}, {"formats", describe_all(device_formats())}, {"options", device_options()}}},
          {"pictures", name_of(pictures)}}},
        {"sample",
         {{"formats", describe_all(sample_formats())},
          {"inputs", describe_all(kMaps)},
          {"masks", describe_all(mask_formats())},
          {"choices", {{"formats", describe_all(choice_formats())}, {"options", choice_options()}}},
          {"pixels", {{"formats", describe_all(pixel_formats())}, {"options", pixel_options()}}},
          {"surfaces",
           {{"inputs", describe_all(kMeshes)},
            {"formats", describe_all(surface_formats())},
            {"options", surface_options()}}},
          {"volumes",
           {{"inputs", describe_all(kVoxels)},
            {"formats", describe_all(volume_formats())},
            {"options", volume_options()}}},
          {"options", sample_options()},
          {"methods", describe_methods(limits)}}},
        {"analyze", {{"formats", describe_all(analyze_formats())}, {"options", analyze_options()}}},
        {"documentation", documentation},
        {"presets", {{"names", presets.names}, {"required", presets.required}}}};
    return document.dump() + '\n';
}

}  // namespace ccdt::api
