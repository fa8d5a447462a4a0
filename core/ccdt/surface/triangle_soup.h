// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/geometry/point3.h"

namespace ccdt {

/// Treatment of picture coordinates outside [0, 1].
enum class Wrap : std::uint32_t { Repeat, Clamp, Mirror };

/// Treatment of the alpha of a material: it is ignored, it becomes 1 from a cutoff on and 0 below, or it is kept.
enum class AlphaMode : std::uint32_t { Opaque, Mask, Blend };

/// Colour of triangles: a factor and, optionally, a picture. Source: glTF 2.0 (ISO/IEC 12113), 3.9, and the extension
/// KHR_texture_transform.
struct Material {
    std::array<float, 4> factor{1, 1, 1, 1};  ///< red, green, blue in linear light, and alpha
    std::uint64_t first_texel = 0;            ///< index in TriangleSoup::texels
    std::uint32_t width = 0;                  ///< width of the picture in texels; 0: no picture
    std::uint32_t height = 0;                 ///< height of the picture in texels; >= 1 if there is a picture
    std::array<Wrap, 2> wrap{};               ///< horizontally and vertically
    AlphaMode alpha = AlphaMode::Opaque;
    float cutoff = 0.5F;  ///< of AlphaMode::Mask
    /// Matrix with two rows, from texture coordinates (s, t, 1) to picture coordinates, whose origin is the upper left
    /// corner.
    std::array<float, 6> transform{1, 0, 0, 0, 1, 0};
};

/// Triangles as a file lists them. They need not form a surface: corners may coincide, triangles may be turned over,
/// overlap, or have no area.
struct TriangleSoup {
    std::vector<Point3> vertices;
    std::vector<std::array<std::uint32_t, 3>> triangles;  ///< indices of vertices; every index is valid
    /// [vertices] red, green, blue in linear light, each in [0, 1]; empty if the file has no colours.
    std::vector<std::array<float, 3>> colours = {};
    std::vector<std::array<float, 2>> texture = {};  ///< [vertices] texture coordinates; empty if the file has none
    std::vector<Material> materials = {};            ///< empty if no triangle has one
    std::vector<std::uint32_t> material_of = {};     ///< [triangles] indices of materials; empty without materials
    std::vector<std::array<std::uint8_t, 4>> texels = {};  ///< of all pictures: sRGB and alpha; rows from the top

    bool has_colours() const { return !colours.empty() || !materials.empty(); }

    /// Returns the picture coordinates of a point of a triangle, in texels. A picture must cover the triangle. The
    /// coordinates may be infinite or NaN.
    /// @param weights  barycentric coordinates
    std::array<double, 2> texel_at(std::uint32_t triangle, const std::array<double, 3>& weights) const;

    /// Whether a picture covers a triangle.
    bool has_picture(std::uint32_t triangle) const {
        return !texture.empty() && !materials.empty() && materials[material_of[triangle]].width > 0;
    }

    /// Returns red, green and blue in linear light, and alpha, at a point of a triangle: the product of the colours of
    /// the vertices, the factor of the material, and its picture, which is interpolated between texels.
    std::array<float, 4> colour_at(std::uint32_t triangle, const std::array<double, 3>& weights) const;

    /// Interpolates values between the corners of a triangle.
    /// @param values  [vertices]
    template <std::size_t kSize>
    std::array<float, kSize> interpolated(const std::vector<std::array<float, kSize>>& values, std::uint32_t triangle,
                                          const std::array<double, 3>& weights) const {
        std::array<float, kSize> value{};
        for (std::size_t k = 0; k < kSize; ++k) {
            double sum = 0;
            for (std::size_t corner = 0; corner < weights.size(); ++corner)
                sum += weights[corner] * static_cast<double>(values[triangles[triangle][corner]][k]);
            value[k] = static_cast<float>(sum);
        }
        return value;
    }
};

}  // namespace ccdt
