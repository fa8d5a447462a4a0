// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "api/surface/surface_header.h"
#include "api/surface/surface_reader.h"

namespace ccdt::api::test {

/// Corners and faces of the unit cube, whose normals point outwards.
constexpr std::array<Point3, 8> kCorners{
    {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}}};
constexpr std::array<std::array<int, 4>, 6> kFaces{
    {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}}};

/// Returns the corners of the cube as text: the coordinates as words, followed by `end`.
inline std::string corners(std::string_view end) {
    std::string text;
    for (const auto& [x, y, z] : kCorners)
        text += std::to_string(int(x)) + ' ' + std::to_string(int(y)) + ' ' + std::to_string(int(z)) + std::string(end);
    return text;
}

/// Returns the faces of the cube as text: for each one `begin`, the indices of its corners, and `end`.
/// @param first  index of the first corner
inline std::string faces(std::string_view begin, std::string_view end, int first = 0) {
    std::string text;
    for (const auto& face : kFaces) {
        text += begin;
        for (const int corner : face) text += ' ' + std::to_string(corner + first);
        text += end;
    }
    return text;
}

inline Result<SurfaceContents> read_mesh(std::string_view bytes) {
    const auto file = open_surface(bytes, {}, 100'000, 0);
    if (!file) return failure(ErrorCode::Unsupported, "not recognised");
    if (!*file) return tl::unexpected(file->error());
    auto contents = read_surface((*file)->bytes, (*file)->header);
    if (contents) {
        EXPECT_EQ(contents->soup.triangles.size(), (*file)->header.max_triangles);
        EXPECT_EQ(contents->soup.vertices.size(), (*file)->header.max_vertices);
    }
    return contents;
}

/// Returns the volume of a closed mesh; it is negative if the normals point inwards.
inline double volume_of(const TriangleSoup& soup) {
    double volume = 0;
    for (const auto& [a, b, c] : soup.triangles)
        volume += dot(soup.vertices[a], cross(soup.vertices[b], soup.vertices[c])) / 6;
    return volume;
}

/// Checks that a file is the unit cube, moved along the axes.
/// @param warning  part of the only warning; empty: there is none
inline void expect_cube(std::string_view file, std::string_view warning = "", Point3 moved = {}) {
    SCOPED_TRACE(std::string(file.substr(0, 400)));
    const auto contents = read_mesh(file);
    ASSERT_TRUE(contents) << contents.error().message;
    const TriangleSoup& soup = contents->soup;
    ASSERT_EQ(soup.triangles.size(), 12U);
    std::vector<Point3> used;
    for (const auto& triangle : soup.triangles) {
        for (const std::uint32_t corner : triangle) used.push_back(soup.vertices[corner]);
    }
    const Box3 box = bounds_of(used);
    EXPECT_EQ(box.min, moved);
    EXPECT_EQ(box.max, (moved + Point3{1, 1, 1}));
    EXPECT_NEAR(volume_of(soup), 1, 1e-12);
    EXPECT_EQ(contents->warnings.size(), warning.empty() ? 0U : 1U);
    for (const std::string& each : contents->warnings) EXPECT_NE(each.find(warning), std::string::npos) << each;
}

/// Checks that a file is refused for a reason.
inline void expect_refused(std::string_view file, std::string_view reason) {
    const auto contents = read_mesh(file);
    ASSERT_FALSE(contents) << file.substr(0, 400);
    EXPECT_EQ(contents.error().code, ErrorCode::Unusable);
    EXPECT_NE(contents.error().message.find(reason), std::string::npos) << contents.error().message;
}

}  // namespace ccdt::api::test
