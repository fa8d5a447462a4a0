// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "api/surface/surface_builder.h"
#include "core/base/result.h"

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

/// Whether a file is a PLY.
inline bool is_ply(std::string_view file) {
    return file.starts_with("ply\n") || file.starts_with("ply\r");
}

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

/// Rows of the vertices of a PLY.
struct PlyRows {
    std::vector<std::vector<double>> columns;  ///< [names][vertices]; NaN for properties that the vertices lack
    std::vector<std::size_t> ends;             ///< [1 + vertices] where the first row begins and each row ends, bytes
};

/// Reads properties of the vertices of a PLY, which needs no faces. Errors: Unusable, with the position in the file.
/// @param names  names of properties that are numbers
Result<PlyRows> read_ply_rows(std::string_view file, std::span<const std::string_view> names);

/// Writes the header of a PLY that has only the vertices of another file, with the same properties and encoding. The
/// header ends where the rows begin.
/// @param vertices  new number of vertices
std::string ply_header_for(std::string_view file, const PlyHeader& header, std::size_t vertices);

}  // namespace ccdt::api
