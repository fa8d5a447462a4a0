// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "api/surface/surface_builder.h"
#include "core/base/result.h"
#include "core/geometry/point3.h"

namespace ccdt::api {

/// Types of numbers in a PLY. Their sizes are 1, 1, 2, 2, 4, 4, 4 and 8 bytes.
enum class PlyType : std::uint8_t { Int8, Uint8, Int16, Uint16, Int32, Uint32, Float32, Float64 };

std::size_t size_of(PlyType type);

struct PlyProperty {
    std::string_view name;
    PlyType type = PlyType::Float32;  ///< of the number, or of the numbers in the list
    PlyType count = PlyType::Uint8;   ///< of the size of the list
    bool is_list = false;
};

struct PlyElement {
    std::string_view name;
    std::uint64_t count = 0;
    std::vector<PlyProperty> properties = {};
};

/// Header of a PLY.
struct PlyHeader {
    enum class Encoding : std::uint8_t { Text, LittleEndian, BigEndian };

    Encoding encoding = Encoding::Text;
    std::vector<PlyElement> elements;
    std::size_t size = 0;                   ///< of the header, bytes
    std::size_t lines = 0;                  ///< of the header
    std::vector<std::size_t> unknown = {};  ///< lines that begin with no keyword

    /// Returns the number of elements with a name; 0 if there are none.
    std::uint64_t count(std::string_view name) const;
};

/// Reads the header of a PLY. The names point into the file. Lines may end as in any system. Errors: Unusable, with the
/// line; also for more than 100 elements or 1,000 properties.
/// Source: Turk, The PLY Polygon File Format.
Result<PlyHeader> read_ply_header(std::string_view file);

/// Reads a PLY. Elements may be in any sequence. Reads the positions, colours and texture coordinates of the element
/// `vertex`, and the lists of corners of `face` and `tristrips`. Skips all other elements and properties.
/// @param sink  SurfaceCounter or SurfaceBuilder
/// Errors: Unusable, with the position in the file.
template <class Sink>
Result<void> read_ply(std::string_view file, Sink& sink);

/// Reads the positions of the vertices of a PLY, which needs no faces. Coordinates that are missing are NaN. Errors:
/// Unusable, with the position in the file.
Result<std::vector<Point3>> read_ply_points(std::string_view file);

}  // namespace ccdt::api
