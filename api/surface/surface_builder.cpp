// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/surface/surface_builder.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "api/surface/polygon_triangles.h"
#include "core/picture/srgb.h"

namespace ccdt::api {
namespace {

constexpr float kNoColour = std::numeric_limits<float>::quiet_NaN();

tl::unexpected<Error> too_many_corners(SurfaceFormat format, const FacePlace& position) {
    return unusable_surface(format,
                            position.text() + " has more than " + std::to_string(kMaxCorners) + " corners, the limit");
}

bool is_finite(Point3 p) {
    return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

}  // namespace

Result<void> SurfaceCounter::face(std::size_t corners, const FacePlace& position) {
    size_.triangles += corners > 2 ? corners - 2 : 0;
    size_.bytes += corners > 3 ? 8 : 0;
    if (corners > kMaxCorners) return too_many_corners(format_, position);
    return {};
}

SurfaceBuilder::SurfaceBuilder(SurfaceFormat format, const SurfaceSize& size)
    : format_(format), vertices_(size.vertices) {
    soup_.vertices.reserve(static_cast<std::size_t>(size.vertices));
    soup_.triangles.reserve(static_cast<std::size_t>(size.triangles));
}

void SurfaceBuilder::vertex(Point3 at, std::size_t line) {
    if (!is_finite(at)) not_finite_.emplace_back(static_cast<std::uint32_t>(soup_.vertices.size()), line);
    soup_.vertices.push_back(at);
}

/// Sets the value of the last vertex.
/// @param missing  value of earlier vertices that have none
template <class Value>
void SurfaceBuilder::set_last(std::vector<Value>& values, const Value& missing, const Value& last) {
    values.reserve(static_cast<std::size_t>(vertices_));
    values.resize(soup_.vertices.size() - 1, missing);
    values.push_back(last);
}

void SurfaceBuilder::colour(const std::array<double, 3>& values) {
    std::array<float, 3> colour{};
    std::ranges::transform(values, colour.begin(), [](double value) { return static_cast<float>(value); });
    set_last(soup_.colours, {kNoColour, kNoColour, kNoColour}, colour);
}

void SurfaceBuilder::texture(const std::array<double, 2>& at) {
    set_last(soup_.texture, {}, {static_cast<float>(at[0]), static_cast<float>(at[1])});
}

Result<void> SurfaceBuilder::face(std::span<const std::uint32_t> corners, const FacePlace& position) {
    if (corners.size() < 3) {
        warn("faces with fewer than three corners are ignored", position.text());
        return {};
    }
    if (corners.size() > kMaxCorners) return too_many_corners(format_, position);
    const std::uint32_t largest = *std::ranges::max_element(corners);
    if (largest > largest_) {
        largest_ = largest;
        largest_at_ = position;
    }
    const auto first = static_cast<std::uint32_t>(soup_.triangles.size());
    for (std::size_t i = 2; i < corners.size(); ++i)
        soup_.triangles.push_back({corners[0], corners[i - 1], corners[i]});
    if (corners.size() > 3) polygons_.push_back({first, static_cast<std::uint32_t>(corners.size() - 2)});
    return {};
}

void SurfaceBuilder::warn(const char* what, std::string where, std::size_t number) {
    const auto known =
        std::ranges::find_if(ignored_, [what](const Ignored& each) { return std::string_view(each.what) == what; });
    if (known == ignored_.end()) {
        ignored_.push_back({what, std::move(where), number});
    } else {
        known->number += number;
    }
}

Result<void> SurfaceBuilder::check_corners() const {
    if (soup_.triangles.empty()) return unusable_surface(format_, "it has no triangles or polygons");
    if (largest_ >= soup_.vertices.size())
        return unusable_surface(format_, largest_at_.text() + " refers to vertex " + std::to_string(largest_) +
                                             ", but there are only " + std::to_string(soup_.vertices.size()) +
                                             " vertices");
    if (not_finite_.empty()) return {};
    for (std::size_t t = 0; t < soup_.triangles.size(); ++t) {
        for (const std::uint32_t v : soup_.triangles[t]) {
            const auto found =
                std::ranges::lower_bound(not_finite_, v, {}, [](const auto& each) { return each.first; });
            if (found == not_finite_.end() || found->first != v) continue;
            const std::string line = found->second > 0 ? " (line " + std::to_string(found->second) + ')' : "";
            return unusable_surface(
                format_, "vertex " + std::to_string(v) + line + " is not finite, in triangle " + std::to_string(t));
        }
    }
    return {};
}

/// Divides polygons, whose triangles are fans so far.
void SurfaceBuilder::divide_polygons() {
    std::vector<std::uint32_t> corners;
    std::vector<Point3> positions;
    for (const Polygon& polygon : polygons_) {
        const auto triangles = std::span(soup_.triangles).subspan(polygon.first, polygon.triangles);
        corners.assign({triangles[0][0], triangles[0][1]});
        for (const auto& triangle : triangles) corners.push_back(triangle[2]);
        positions.clear();
        for (const std::uint32_t corner : corners) positions.push_back(soup_.vertices[corner]);
        divide_polygon(positions, triangles);
        for (auto& triangle : triangles) {
            for (std::uint32_t& corner : triangle) corner = corners[corner];
        }
    }
}

/// Moves colours into their range and, except those of a glTF, from sRGB to linear light.
void SurfaceBuilder::convert_colours() {
    auto& colours = soup_.colours;
    if (colours.empty()) return;
    colours.resize(soup_.vertices.size(), {kNoColour, kNoColour, kNoColour});
    float largest = 0;
    for (const auto& colour : colours) {
        for (const float value : colour) largest = std::max(largest, value);  // NaN is not greater
    }
    const bool is_linear = format_ == SurfaceFormat::Gltf || format_ == SurfaceFormat::Glb;
    const float scale = !is_linear && largest > 2 ? 255 : 1;
    for (auto& colour : colours) {
        for (float& value : colour) {
            if (value < 0 || value > scale) warn("values of colours are moved into their range", "");
            const float share = std::isnan(value) ? 1 : std::clamp(value / scale, 0.F, 1.F);
            value = is_linear ? share : light_of_srgb(share);
        }
    }
}

Result<SurfaceContents> SurfaceBuilder::finish() {
    if (const auto checked = check_corners(); !checked) return tl::unexpected(checked.error());
    divide_polygons();
    convert_colours();
    if (!soup_.texture.empty()) soup_.texture.resize(soup_.vertices.size());
    SurfaceContents contents{std::move(soup_)};
    for (const auto& [what, where, number] : ignored_)
        contents.warnings.push_back(what + (": " + std::to_string(number)) +
                                    (where.empty() ? "" : "; the first is " + where));
    return contents;
}

}  // namespace ccdt::api
