// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/surface/triangle_soup.h"

#include <algorithm>
#include <cmath>

#include "core/picture/srgb.h"

namespace ccdt {

namespace {

/// A position between two texels of a row or column.
struct Between {
    std::size_t first, second;
    float share;  ///< of the second one
};

/// Wraps a picture coordinate in texels.
Between wrapped(double at, std::uint32_t size, Wrap wrap) {
    const double period = wrap == Wrap::Mirror ? 2.0 * size : size;
    if (!std::isfinite(at)) at = 0;
    at = wrap == Wrap::Clamp ? std::clamp(at, 0.0, period) : at - period * std::floor(at / period);
    const double first = std::floor(at - 0.5);
    const auto index = [&](double texel) {
        if (wrap == Wrap::Repeat) texel -= period * std::floor(texel / period);
        if (wrap == Wrap::Mirror && texel >= size) texel = period - 1 - texel;
        return static_cast<std::size_t>(std::clamp(texel, 0.0, size - 1.0));
    };
    return {index(first), index(first + 1), static_cast<float>(at - 0.5 - first)};
}

std::array<float, 4> light_of(const std::array<std::uint8_t, 4>& texel) {
    static const auto kLight = [] {
        std::array<float, 256> light{};
        for (std::size_t i = 0; i < light.size(); ++i) light[i] = light_of_srgb(static_cast<float>(i) / 255);
        return light;
    }();
    const auto [red, green, blue, alpha] = texel;
    return {kLight[red], kLight[green], kLight[blue], static_cast<float>(alpha) / 255};
}

}  // namespace

std::array<double, 2> TriangleSoup::texel_at(std::uint32_t triangle, const std::array<double, 3>& weights) const {
    const Material& material = materials[material_of[triangle]];
    const auto at = interpolated(texture, triangle, weights);
    const auto& m = material.transform;
    const auto row = [&](std::size_t i) { return static_cast<double>(m[i] * at[0] + m[i + 1] * at[1] + m[i + 2]); };
    return {row(0) * material.width, row(3) * material.height};
}

std::array<float, 4> TriangleSoup::colour_at(std::uint32_t triangle, const std::array<double, 3>& weights) const {
    std::array<float, 4> colour{1, 1, 1, 1};
    if (!colours.empty()) std::ranges::copy(interpolated(colours, triangle, weights), colour.begin());
    if (materials.empty()) return colour;
    const Material& material = materials[material_of[triangle]];
    for (std::size_t k = 0; k < colour.size(); ++k) colour[k] *= material.factor[k];
    if (has_picture(triangle)) {
        const auto at = texel_at(triangle, weights);
        const Between x = wrapped(at[0], material.width, material.wrap[0]);
        const Between y = wrapped(at[1], material.height, material.wrap[1]);
        const auto light = [&](std::size_t column, std::size_t row) {
            return light_of(texels[material.first_texel + row * material.width + column]);
        };
        const auto a = light(x.first, y.first), b = light(x.second, y.first);
        const auto c = light(x.first, y.second), d = light(x.second, y.second);
        for (std::size_t k = 0; k < colour.size(); ++k) {
            const float above = a[k] + x.share * (b[k] - a[k]), below = c[k] + x.share * (d[k] - c[k]);
            colour[k] *= above + y.share * (below - above);
        }
    }
    if (material.alpha == AlphaMode::Opaque) colour[3] = 1;
    if (material.alpha == AlphaMode::Mask) colour[3] = colour[3] >= material.cutoff ? 1 : 0;
    return colour;
}

}  // namespace ccdt
