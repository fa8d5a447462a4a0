// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/spatial/point_format3.h"

#include <algorithm>
#include <cstdint>

#include "api/json/json_document.h"
#include "api/output/json_pieces.h"

namespace ccdt::api {

std::string write_notes(std::span<const SurfaceNote> notes) {
    std::string out;
    append_array(out, notes, [](std::string& to, const SurfaceNote& note) {
        to += R"({"pointer":"","detail":)";
        append_ascii_json_text(to, note.detail);
        if (note.triangle) append_member(to, "face", std::uint64_t{*note.triangle});
        to += '}';
    });
    return out;
}

std::string header_of(std::span<const SurfaceNote> notes) {
    constexpr std::size_t kMaxInHeader = 8;  // each note takes about 100 characters
    return notes.empty() ? std::string() : write_notes(notes.first(std::min(notes.size(), kMaxInHeader)));
}

std::string ply_header(std::size_t vertices) {
    return "ply\nformat binary_little_endian 1.0\nelement vertex " + std::to_string(vertices) + "\n";
}

}  // namespace ccdt::api
