// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <string>

#include "api/surface/surface_reader.h"
#include "tests/fuzz/checks.h"

namespace ccdt::fuzz {
namespace {

constexpr std::size_t kMaxFaces = 1000;

/// Checks that a soup is consistent and within the bounds of its header.
void check_contents(const api::SurfaceContents& contents, const api::SurfaceHeader& header) {
    const auto& [vertices, triangles, colours, texture] = contents.soup;
    CCDT_CHECK(!triangles.empty() && triangles.size() <= header.max_triangles);
    CCDT_CHECK(vertices.size() <= header.max_vertices);
    CCDT_CHECK(colours.empty() || colours.size() == vertices.size());
    CCDT_CHECK(texture.empty() || texture.size() == vertices.size());
    for (const auto& triangle : triangles) CCDT_CHECK(std::ranges::max(triangle) < vertices.size());
    for (const auto& colour : colours) CCDT_CHECK(std::ranges::min(colour) >= 0 && std::ranges::max(colour) <= 1);
}

}  // namespace
}  // namespace ccdt::fuzz

/// Reads a mesh file.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace ccdt;
    const std::string_view file = fuzz::text_of(data, size);
    const auto format = api::recognise_surface(file);
    if (!format) return 0;
    const auto header = api::read_surface_header(file, *format, fuzz::kMaxFaces);
    if (!header) {
        fuzz::check_error(header.error());
        return 0;
    }
    CCDT_CHECK(header->max_triangles >= 1 && header->max_triangles <= fuzz::kMaxFaces);
    if (const auto contents = api::read_surface(file, *header)) {
        fuzz::check_contents(*contents, *header);
    } else {
        fuzz::check_error(contents.error());
    }
    return 0;
}
