// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <string>

#include "api/decode/decode.h"
#include "tests/fuzz/checks.h"
#include "tests/fuzz/shape_checks.h"

namespace ccdt::fuzz {
namespace {

constexpr std::size_t kMaxFaces = 1000, kMaxPixels = 10'000;

/// Checks that a soup is consistent and within the bounds of its header.
void check_contents(const api::SurfaceContents& contents, const api::SurfaceHeader& header) {
    const TriangleSoup& soup = contents.soup;
    check_soup(soup);
    CCDT_CHECK(soup.triangles.size() <= header.max_triangles && soup.vertices.size() <= header.max_vertices);
    CCDT_CHECK(soup.texels.size() <= header.texels && header.texels <= kMaxPixels);
    for (const auto& colour : soup.colours) CCDT_CHECK(std::ranges::min(colour) >= 0 && std::ranges::max(colour) <= 1);
}

}  // namespace
}  // namespace ccdt::fuzz

/// Reads a mesh file and its pictures.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace ccdt;
    const std::string_view file = fuzz::text_of(data, size);
    const auto format = api::recognise_surface(file);
    if (!format) return 0;
    const auto header = api::read_surface_header(file, *format, fuzz::kMaxFaces, fuzz::kMaxPixels);
    if (!header) {
        fuzz::check_error(header.error());
        return 0;
    }
    CCDT_CHECK(header->max_triangles >= 1 && header->max_triangles <= fuzz::kMaxFaces);
    if (const auto contents = api::read_surface_with_pictures(file, *header)) {
        fuzz::check_contents(*contents, *header);
    } else {
        fuzz::check_error(contents.error());
    }
    return 0;
}
