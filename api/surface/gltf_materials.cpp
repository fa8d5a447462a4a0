// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/surface/gltf_materials.h"

#include <algorithm>
#include <cmath>

#include "api/image/image_header.h"
#include "api/image/srgb.h"
#include "core/base/elementary.h"

namespace ccdt::api {
namespace {

using Value = GltfDocument::Value;

constexpr std::size_t kMaxSets = std::size_t{1} << 16;  ///< of texture coordinates

/// Returns the nearest number from 0 to 1; 0 for NaN.
float share_of(double value) {
    return value > 0 ? static_cast<float>(std::min(value, 1.0)) : 0;
}

Value base_texture(Value material) {
    return GltfDocument::member(material, "pbrMetallicRoughness", "baseColorTexture");
}

Value transform_of(Value texture) {
    return GltfDocument::member(texture, "extensions", "KHR_texture_transform");
}

/// Returns the index of the image of a texture; none if it is missing.
std::optional<std::size_t> image_of(const GltfDocument& gltf, Value texture) {
    const auto object = gltf.element("textures", GltfDocument::member(texture, "index"));
    const auto webp = GltfDocument::member(object, "extensions", "EXT_texture_webp");
    const auto source = GltfDocument::member(webp ? webp : object, "source");
    return GltfDocument::index(source, gltf.array("images").size());
}

std::uint8_t srgb_of(float light) {
    static const auto kValues = [] {
        std::vector<std::uint8_t> values(1 << 16);  // enough to tell the darkest sRGB values apart
        for (std::size_t i = 0; i < values.size(); ++i)
            values[i] = to_srgb(static_cast<double>(i) / static_cast<double>(values.size() - 1));
        return values;
    }();
    return kValues[static_cast<std::size_t>(
        std::lround(share_of(double{light}) * static_cast<float>(kValues.size() - 1)))];
}

Wrap wrap_of(Value mode) {
    constexpr double kClampToEdge = 33071, kMirroredRepeat = 33648;
    const double number = GltfDocument::number(mode, 0);
    return number == kClampToEdge ? Wrap::Clamp : number == kMirroredRepeat ? Wrap::Mirror : Wrap::Repeat;
}

}  // namespace

void add_pictures(const GltfDocument& gltf, std::size_t max_pixels, SurfaceHeader& header) {
    std::vector<std::uint8_t> is_texture_used(gltf.array("textures").size()), is_used(gltf.array("images").size());
    for (const JsonValue material : gltf.array("materials")) {
        const Value texture = base_texture(material);
        const auto index = GltfDocument::index(GltfDocument::member(texture, "index"), is_texture_used.size());
        if (!index || std::exchange(is_texture_used[*index], std::uint8_t{1}) != 0) continue;
        if (const auto image = image_of(gltf, texture)) is_used[*image] = 1;
    }
    std::uint64_t largest = 0;
    for (std::size_t i = 0; i < is_used.size(); ++i) {
        if (is_used[i] == 0) continue;
        const auto picture = read_image_header(gltf.bytes_of_image(gltf.array("images")[i]), max_pixels);
        if (!picture) continue;                // the decoder reports the error
        constexpr std::uint64_t kPlanes = 16;  // bytes of a pixel
        largest = std::max(largest, picture->decoder_bytes + kPlanes * picture->pixels());
        header.texels += picture->pixels();
    }
    header.max_pixels = max_pixels;
    header.texels = std::min<std::uint64_t>(header.texels, max_pixels);
    header.decoder_bytes += largest + 2 * sizeof(TriangleSoup::texels[0]) * header.texels;
}

GltfMaterials::GltfMaterials(const GltfDocument& gltf, const SurfaceHeader& header, const DecodePicture& decode,
                             TriangleSoup& soup)
    : gltf_(gltf), header_(header), decode_(decode), soup_(soup) {
    soup.texels.reserve(static_cast<std::size_t>(header.texels));
}

std::uint32_t GltfMaterials::number_of(Value material) {
    const std::size_t missing = gltf_.array("materials").size();
    const auto next = static_cast<std::uint32_t>(soup_.materials.size());
    const auto [found, is_new] = numbers_.try_emplace(GltfDocument::index(material, missing).value_or(missing), next);
    if (is_new) soup_.materials.push_back(read(gltf_.element("materials", material)));
    return found->second;
}

std::size_t GltfMaterials::coordinates_of(Value material) const {
    const Value texture = base_texture(gltf_.element("materials", material));
    const auto moved = GltfDocument::index(GltfDocument::member(transform_of(texture), "texCoord"), kMaxSets);
    return moved.value_or(GltfDocument::index(GltfDocument::member(texture, "texCoord"), kMaxSets).value_or(0));
}

Material GltfMaterials::read(Value from) {
    Material material;
    const Value colours = GltfDocument::member(from, "pbrMetallicRoughness");
    if (const auto factor = GltfDocument::numbers(GltfDocument::member(colours, "baseColorFactor"), 4); !factor.empty())
        std::ranges::transform(factor, material.factor.begin(), share_of);
    const std::string_view mode = GltfDocument::text(GltfDocument::member(from, "alphaMode"));
    if (mode == "MASK") material.alpha = AlphaMode::Mask;
    if (mode == "BLEND") material.alpha = AlphaMode::Blend;
    material.cutoff =
        static_cast<float>(GltfDocument::number(GltfDocument::member(from, "alphaCutoff"), double{material.cutoff}));
    if (const Value texture = base_texture(from)) read_texture(texture, material);
    return material;
}

void GltfMaterials::read_texture(Value texture, Material& material) {
    const Value object = gltf_.element("textures", GltfDocument::member(texture, "index"));
    const Value sampler = gltf_.element("samplers", GltfDocument::member(object, "sampler"));
    material.wrap = {wrap_of(GltfDocument::member(sampler, "wrapS")), wrap_of(GltfDocument::member(sampler, "wrapT"))};
    if (const Value transform = transform_of(texture)) {
        const auto pair = [&](std::string_view name, double missing) {
            const Value value = GltfDocument::member(transform, name);
            auto numbers = GltfDocument::numbers(value, 2);
            if (value && numbers.empty()) report("a KHR_texture_transform is damaged");
            return numbers.empty() ? std::vector<double>{missing, missing} : numbers;
        };
        const auto offset = pair("offset", 0), scale = pair("scale", 1);
        const double angle = GltfDocument::number(GltfDocument::member(transform, "rotation"), 0);
        const double sine = elementary::sin(angle), cosine = elementary::cos(angle);
        const std::array<double, 6> matrix{cosine * scale[0], sine * scale[1],   offset[0],
                                           -sine * scale[0],  cosine * scale[1], offset[1]};
        std::ranges::transform(matrix, material.transform.begin(),
                               [](double each) { return static_cast<float>(each); });
    }
    const auto image = image_of(gltf_, texture);
    if (!image) return report("the picture of a texture is missing");
    const auto place = add_picture(*image);
    if (!place) return report(place.error().message);
    material.first_texel = place->first;
    material.width = place->width;
    material.height = place->height;
}

/// Adds a picture to the soup, unless it is there already.
Result<GltfMaterials::Place> GltfMaterials::add_picture(std::size_t image) {
    const auto [found, is_new] = pictures_.try_emplace(image);
    if (!is_new) return found->second;
    const auto fail = [&](const std::string& reason) {
        return failure(ErrorCode::Unusable, "the embedded texture " + std::to_string(image) + ' ' + reason);
    };
    const JsonValue object = gltf_.array("images")[image];
    const std::string_view uri = GltfDocument::text(GltfDocument::member(object, "uri"));
    if (!uri.empty() && !uri.starts_with("data:"))
        return failure(ErrorCode::Unusable, "the texture " + std::string(uri.substr(0, 100)) +
                                                " is in another file; embed it, for example in a GLB");
    const std::string bytes = gltf_.bytes_of_image(object);
    if (bytes.empty()) return failure(ErrorCode::Unusable, "the picture of a texture has no bytes");
    const auto picture = decode_(bytes, static_cast<std::size_t>(header_.max_pixels));
    if (!picture) return fail("cannot be read: " + picture.error().message);
    auto& texels = soup_.texels;
    const std::size_t pixels = picture->red.size();
    if (pixels > header_.texels - texels.size())
        return fail("cannot be read: all textures together exceed this server's limit (max-pixels), " +
                    std::to_string(header_.max_pixels));
    found->second = {texels.size(), static_cast<std::uint32_t>(picture->width),
                     static_cast<std::uint32_t>(picture->height)};
    for (std::size_t i = 0; i < pixels; ++i) {
        const float alpha = picture->alpha.empty() ? 1 : share_of(double{picture->alpha[i]});
        texels.push_back({srgb_of(picture->red[i]), srgb_of(picture->green[i]), srgb_of(picture->blue[i]),
                          static_cast<std::uint8_t>(std::lround(255 * alpha))});
    }
    return found->second;
}

}  // namespace ccdt::api
