// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "api/surface/surface_format.h"
#include "core/base/result.h"
#include "core/ccdt/surface/triangle_soup.h"
#include "core/geometry/point3.h"

namespace ccdt::api {

/// Maximum number of corners of a polygon.
constexpr std::size_t kMaxCorners = 10'000;

/// Size of a mesh, which the first reading of a file determines.
struct SurfaceSize {
    std::uint64_t vertices = 0;
    std::uint64_t triangles = 0;
    std::uint64_t materials = 0;
    std::uint64_t bytes = 0;  ///< memory for reading the file, in addition to the mesh itself
};

/// Contents of a mesh file.
struct SurfaceContents {
    TriangleSoup soup;
    std::vector<std::string> warnings = {};  ///< what was ignored, for users
    std::string picture_error = {};          ///< why a picture of a material could not be used; empty if all were used
};

/// A position in a file: a face, and its line if the file is a text.
struct FacePlace {
    std::uint64_t face = 0;
    std::size_t line = 0;  ///< from 1; 0: not a text

    std::string text() const {
        return "face " + std::to_string(face) + (line > 0 ? " (line " + std::to_string(line) + ')' : "");
    }
};

/// Counts the vertices and triangles of a file without reading their numbers. A reader is a template over this class
/// and SurfaceBuilder, so that both readings of a file agree.
class SurfaceCounter {
public:
    static constexpr bool kReads = false, kIsMesh = true;

    explicit SurfaceCounter(SurfaceFormat format) : format_(format) {}

    void vertex(Point3, std::size_t) { ++size_.vertices; }
    void colour(const std::array<double, 3>&) {}
    void texture(const std::array<double, 2>&) {}
    void warn(const char*, const std::string&, std::size_t = 1) {}

    /// Counts the triangles of a polygon. Errors: Unusable for too many corners.
    Result<void> face(std::span<const std::uint32_t> corners, const FacePlace& position) {
        return face(corners.size(), position);
    }
    Result<void> face(std::size_t corners, const FacePlace& position);

    /// Adds memory that reading needs.
    void need(std::uint64_t bytes) { size_.bytes += bytes; }
    void materials(std::uint64_t number) { size_.materials = number; }

    const SurfaceSize& size() const { return size_; }

private:
    SurfaceFormat format_;
    SurfaceSize size_;
};

/// Makes a mesh of the vertices and polygons of a file. Faces may refer to vertices that follow later.
class SurfaceBuilder {
public:
    static constexpr bool kReads = true, kIsMesh = true;

    SurfaceBuilder(SurfaceFormat format, const SurfaceSize& size);

    /// Adds a vertex.
    /// @param line  in the file, from 1; 0: not a text
    void vertex(Point3 at, std::size_t line);
    /// Adds the colour of the last vertex: red, green and blue, in linear light for a glTF and in sRGB otherwise, from
    /// 0 to 1. In sRGB, if any value is greater than 2, they are from 0 to 255. A vertex without a colour, or with NaN,
    /// is white.
    void colour(const std::array<double, 3>& values);
    /// Adds the texture coordinates of the last vertex. Those of other vertices are 0.
    void texture(const std::array<double, 2>& at);
    /// Adds a polygon. Faces with fewer than three corners are ignored, with a warning.
    /// @param corners  indices of vertices
    Result<void> face(std::span<const std::uint32_t> corners, const FacePlace& position);
    /// Counts something that is ignored.
    /// @param what    calls with the same text are counted together
    /// @param where   position of the first one in the file
    /// @param number  how often it occurs there
    void warn(const char* what, std::string where, std::size_t number = 1);

    /// Ends the mesh: divides polygons, and checks all indices and the positions of corners. Errors: Unusable, with the
    /// position in the file.
    Result<SurfaceContents> finish();

    TriangleSoup& soup() { return soup_; }

private:
    struct Polygon {
        std::uint32_t first;  ///< its first triangle
        std::uint32_t triangles;
    };
    struct Ignored {
        const char* what;
        std::string where;
        std::size_t number;
    };

    Result<void> check_corners() const;
    void divide_polygons();
    void convert_colours();
    template <class Value>
    void set_last(std::vector<Value>& values, const Value& missing, const Value& last);

    SurfaceFormat format_;
    TriangleSoup soup_;
    std::vector<Polygon> polygons_;
    std::vector<Ignored> ignored_;
    std::uint32_t largest_ = 0;  ///< largest index of a corner
    FacePlace largest_at_;
    std::vector<std::pair<std::uint32_t, std::size_t>> not_finite_;  ///< vertices and their lines
    std::uint64_t vertices_ = 0;                                     ///< announced
};

}  // namespace ccdt::api
