// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/volume/unwrapped_mesh.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <map>

namespace ccdt {

std::optional<TetrahedronMesh> unwrapped(const TetrahedronMesh& mesh, Point3 sides) {
    /// Number of a vertex, and the number of sides by which a copy is shifted along each axis.
    using Copy = std::array<std::int32_t, 4>;
    std::map<Copy, std::uint32_t> copies;
    TetrahedronMesh result = mesh;
    double volume = 0;
    for (Tetrahedron& corners : result.tetrahedra) {
        const Point3 first = mesh.vertices[corners[0]];
        std::array<Point3, 4> edges;  // from the first corner, in sides, so that no product overflows
        for (std::size_t i = 1; i < corners.size(); ++i) {
            const Point3 p = mesh.vertices[corners[i]], d = p - first;
            const Point3 turns{-std::round(d.x / sides.x), -std::round(d.y / sides.y), -std::round(d.z / sides.z)};
            const Point3 position{p.x + turns.x * sides.x, p.y + turns.y * sides.y, p.z + turns.z * sides.z};
            edges[i] = {d.x / sides.x + turns.x, d.y / sides.y + turns.y, d.z / sides.z + turns.z};
            if (turns == Point3()) continue;
            const Copy copy{static_cast<std::int32_t>(corners[i]), static_cast<std::int32_t>(turns.x),
                            static_cast<std::int32_t>(turns.y), static_cast<std::int32_t>(turns.z)};
            const auto number = static_cast<std::uint32_t>(result.vertices.size());
            const auto [found, is_new] = copies.try_emplace(copy, number);
            if (is_new) result.vertices.push_back(position);
            corners[i] = found->second;
        }
        volume += std::abs(dot(cross(edges[1], edges[2]), edges[3])) / 6;
    }
    constexpr double kRounding = 1e-6;
    if (std::abs(volume - 1) > kRounding) return std::nullopt;
    return result;
}

}  // namespace ccdt
