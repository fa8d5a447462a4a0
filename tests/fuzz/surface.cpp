// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/surface/surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

#include "core/ccdt/surface/surface_density.h"
#include "core/ccdt/surface/surface_repair.h"
#include "tests/fuzz/checks.h"
#include "tests/support/surfaces.h"

namespace ccdt::fuzz {
namespace {

constexpr unsigned kMaxVertices = 32, kMaxTriangles = 64;
constexpr int kMaxMoves = 16;

/// Encoding of a vertex, given by the lowest two bits of its first byte.
enum class Vertex { Grid, Neighbour, Fine, Any };

/// Reads a vertex. Vertices on the small grid often coincide, and their triangles overlap. Neighbour yields a vertex
/// near `before`, the preceding one.
Point3 read_vertex(Bytes& input, Point3 before) {
    const auto first = input.take<std::uint8_t>();
    switch (static_cast<Vertex>(first % 4U)) {
        case Vertex::Grid:
            return {static_cast<double>(first / 4U % 4U), static_cast<double>(first / 16U % 4U),
                    static_cast<double>(first / 64U)};
        case Vertex::Neighbour: {
            const double step = std::ldexp(input.take<std::int8_t>(), -static_cast<int>(first / 4U));
            return before + Point3{step, first % 8U == 1 ? step : 0, 0};
        }
        case Vertex::Fine: {
            const auto x = input.take<std::int16_t>();
            const auto y = input.take<std::int16_t>();
            return {x / 8192.0, y / 8192.0, first / 64.0};
        }
        case Vertex::Any: {
            const auto x = input.take<double>();
            const auto y = input.take<double>();
            return {x, y, input.take<double>()};
        }
    }
    return {};
}

TriangleSoup read_soup(Bytes& input) {
    TriangleSoup soup;
    soup.vertices.resize(input.take<std::uint8_t>() % kMaxVertices + 1);
    soup.triangles.resize(input.take<std::uint8_t>() % kMaxTriangles);
    Point3 before;
    for (Point3& vertex : soup.vertices) before = vertex = read_vertex(input, before);
    for (auto& triangle : soup.triangles) {
        for (std::uint32_t& corner : triangle) {
            corner = static_cast<std::uint32_t>(input.take<std::uint8_t>() % soup.vertices.size());
        }
    }
    return soup;
}

void check_notes(const Surface::Made& made, const TriangleSoup& soup) {
    for (const SurfaceNote& note : made.repairs) {
        CCDT_CHECK(!note.detail.empty() && note.count > 0);
        CCDT_CHECK(note.triangle && *note.triangle < soup.triangles.size());
    }
}

/// Checks that faces are of different triangles, and have their corners, up to the rounding of vertices.
void check_frame(const Surface& surface, const TriangleSoup& soup) {
    std::vector<bool> used(soup.triangles.size(), false);
    for (std::uint32_t f = 0; f < surface.face_count(); ++f) {
        CCDT_CHECK(!used[surface.triangle_of(f)]);
        used[surface.triangle_of(f)] = true;
        const SurfacePoint point{f, {0.25, 0.3, 0.45}};
        const auto weights = surface.original_weights(point);
        Point3 p;
        for (std::size_t k = 0; k < 3; ++k) {
            p = p + weights[k] * surface.from_input(soup.vertices[soup.triangles[surface.triangle_of(f)][k]]);
        }
        CCDT_CHECK(length(p - surface.position(point)) < 1e-10);
    }
}

void check_nearest(const Surface& surface, Point3 p) {
    const SurfacePoint nearest = surface.nearest(p);
    CCDT_CHECK(test::is_on(nearest, surface));
    if (!(std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}) < 100)) return;
    const double distance = length(surface.position(nearest) - p);
    for (std::uint32_t f = 0; f < surface.face_count(); ++f) {
        const auto positions = surface.positions(f);
        if (ConnectedTriangles::is_flat(positions)) continue;
        const auto& [a, b, c] = positions;
        for (const Point3& q : {a, b, c, 0.5 * (a + b), 0.2 * a + 0.3 * b + 0.5 * c}) {
            CCDT_CHECK(distance <= length(q - p) + 1e-9);
        }
    }
}

void check_walk(const Surface& surface, Bytes& input) {
    SurfacePoint point;
    for (int i = 0; i < kMaxMoves && !input.empty(); ++i) {
        const Point3 move = read_vertex(input, {});
        const SurfacePoint before = point;
        point = surface.trace(before, move);
        CCDT_CHECK(test::is_on(point, surface));
        CCDT_CHECK(surface.component(point.face) == surface.component(before.face));
        CCDT_CHECK(!(length(surface.position(point) - surface.position(before)) > length(move) + 1e-6));
        CCDT_CHECK(std::abs(length(surface.smooth_normal(point)) - 1) < 1e-9);
        if (!std::isnan(move.x + move.y + move.z)) check_nearest(surface, move);
        if (i % 4 == 3)
            point = {static_cast<std::uint32_t>(i) % static_cast<std::uint32_t>(surface.face_count()), {0, 1, 0}};
    }
}

void check_density(const Surface& surface) {
    constexpr double kContrast = 8;
    for (const double spacing : {1e-3, 0.1, 10.}) {
        const SurfaceDensity density = SurfaceDensity::of_curvature(surface, spacing, kContrast);
        for (std::uint32_t f = 0; f < surface.face_count(); ++f) {
            for (std::uint32_t k = 0; k < 3; ++k) {
                CCDT_CHECK(density.at_corner(f, k) >= 1 && density.at_corner(f, k) <= kContrast);
            }
        }
    }
}

}  // namespace
}  // namespace ccdt::fuzz

/// Makes surfaces of few triangles, follows lines on them, and finds nearest points.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace ccdt;
    using namespace ccdt::fuzz;
    Bytes input(text_of(data, size));
    const auto crease = input.take<std::uint8_t>();
    const TriangleSoup soup = read_soup(input);
    const auto made = Surface::create(soup, crease == 0 ? std::nullopt : std::optional(crease / 64.0));
    if (!made) {
        check_error(made.error());
        return 0;
    }
    CCDT_CHECK(test::fault_in(made->surface).empty());
    check_notes(*made, soup);
    check_frame(made->surface, soup);
    check_walk(made->surface, input);
    check_density(made->surface);
    return 0;
}
