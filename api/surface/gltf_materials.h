// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "api/surface/gltf_document.h"
#include "api/surface/surface_format.h"
#include "core/base/result.h"
#include "core/ccdt/surface/triangle_soup.h"
#include "core/picture/picture.h"

namespace ccdt::api {

/// Decodes the file of a picture. Errors: those of decode_colour_image().
using DecodePicture = std::function<Result<ColourPicture>(std::string_view bytes, std::size_t max_pixels)>;

/// Adds the pictures that base colours of a glTF use to its header: their pixels, and the memory for reading them.
void add_pictures(const GltfDocument& gltf, std::size_t max_pixels, SurfaceHeader& header);

/// Reads the base colours of the materials of a glTF, in the order in which they are used.
class GltfMaterials {
public:
    /// @param soup  receives the materials and their pictures
    GltfMaterials(const GltfDocument& gltf, const SurfaceHeader& header, const DecodePicture& decode,
                  TriangleSoup& soup);

    /// Returns the index in TriangleSoup::materials of the material of a primitive.
    std::uint32_t number_of(GltfDocument::Value material);

    /// Returns the set of texture coordinates that the material of a primitive uses.
    std::size_t coordinates_of(GltfDocument::Value material) const;

    /// Returns why a picture could not be used; empty if all were used.
    const std::string& error() const { return error_; }
    void report(const std::string& error) {
        if (error_.empty()) error_ = error;
    }

private:
    struct Place {
        std::size_t first = 0;
        std::uint32_t width = 0, height = 0;
    };

    Material read(GltfDocument::Value from);
    void read_texture(GltfDocument::Value texture, Material& material);
    Result<Place> add_picture(std::size_t image);

    const GltfDocument& gltf_;
    const SurfaceHeader& header_;
    const DecodePicture& decode_;
    TriangleSoup& soup_;
    std::map<std::size_t, std::uint32_t> numbers_;  ///< of materials by index in the file; their count: no material
    std::map<std::size_t, Place> pictures_;         ///< of the images
    std::string error_;
};

}  // namespace ccdt::api
