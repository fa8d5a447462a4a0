// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/surface/off.h"

#include <cstdint>
#include <optional>

#include "api/surface/surface_format.h"
#include "api/text/text.h"

namespace ccdt::api {
namespace {

constexpr std::string_view kBlanks = " \t\r\n\v\f";

/// Removes the next line that is not empty from a text. Returns it without its comment and surrounding blanks.
std::string_view take_line(std::string_view& text) {
    std::string_view line;
    while (line.empty() && !text.empty()) {
        line = take_until(text, "\n");
        line = trim(take_until(line, "#"), kBlanks);
    }
    return line;
}

/// Removes the first word of a line. Returns the word.
std::string_view take_word(std::string_view& line) {
    line = trim(line, kBlanks);
    const std::string_view word = line.substr(0, line.find_first_of(kBlanks));
    line.remove_prefix(word.size());
    return word;
}

/// Beginning of a file: the prefixes of its keyword, which state the properties of vertices, and the numbers of
/// vertices and faces.
struct Header {
    bool has_texture = false;
    bool has_colours = false;
    bool has_normals = false;
    std::string_view vertices, faces;
    std::string_view data;  ///< the lines of the vertices and faces
};

bool take_prefix(std::string_view& text, std::string_view prefix) {
    if (!text.starts_with(prefix)) return false;
    text.remove_prefix(prefix.size());
    return true;
}

/// Reads the beginning of a file; returns none if its keyword is not that of an OFF.
std::optional<Header> read_header(std::string_view text) {
    Header header;
    std::string_view line = take_line(text), word = take_word(line);
    header.has_texture = take_prefix(word, "ST");
    header.has_colours = take_prefix(word, "C");
    header.has_normals = take_prefix(word, "N");
    if (word != "OFF") return std::nullopt;
    if (trim(line, kBlanks).empty()) line = take_line(text);
    header.vertices = take_word(line);
    header.faces = take_word(line);
    header.data = text;
    return header;
}

/// Returns the type of the colours of vertices: `uchar` for integers from 0 to 255, `float` for numbers from 0 to 1.
std::string_view type_of_colours(const Header& header) {
    std::string_view data = header.data, line = take_line(data);
    for (int i = 0; i < (header.has_normals ? 6 : 3); ++i) take_word(line);  // the position and the normal
    return line.find('.') == std::string_view::npos ? "uchar" : "float";
}

}  // namespace

bool is_off(std::string_view text) {
    return read_header(text).has_value();
}

Result<std::string> ply_of_off(std::string_view text) {
    const auto header = read_header(text);
    if (!header || !parse_number<std::uint32_t>(header->vertices) || !parse_number<std::uint32_t>(header->faces))
        return unusable_surface(SurfaceFormat::Off, "it does not begin with OFF and the numbers of vertices and faces");
    std::string ply = "ply\nformat ascii 1.0\nelement vertex " + std::string(header->vertices) + '\n';
    ply.reserve(header->data.size() + 500);
    const auto add = [&ply](std::string_view type, std::string_view names) {
        while (!names.empty()) ply.append("property ").append(type).append(" ").append(take_until(names, " ")) += '\n';
    };
    add("float", "x y z");
    if (header->has_normals) add("float", "nx ny nz");
    if (header->has_colours) add(type_of_colours(*header), "red green blue");
    // After colours, texture coordinates are not read: their column is unknown, because alpha is optional.
    if (header->has_texture && !header->has_colours) add("float", "s t");
    ply += "element face " + std::string(header->faces) + "\nproperty list int int vertex_indices\nend_header\n";
    for (std::string_view data = header->data; !data.empty();) ply.append(take_line(data)) += '\n';
    return ply;
}

}  // namespace ccdt::api
