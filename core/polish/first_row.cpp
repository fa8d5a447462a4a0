#include "core/polish/first_row.h"

#include <algorithm>
#include <cmath>

namespace ccdt {

void keep_off_border(const Triangulation& mesh, std::span<const double> spacings, double depth,
                     std::span<Point> moves) {
    const auto keep_off = [&](std::uint32_t site, Point away, double distance) {
        const double least = std::min(distance, depth * spacings[site]), left = distance + dot(moves[site], away);
        if (left < least) moves[site] = moves[site] + (least - left) * away;
    };
    // What is far enough for any direction of its move needs no root.
    const auto is_far = [&](std::uint32_t site, double squared) {
        const double least = depth * spacings[site];
        return squared > 2 * (least * least + dot(moves[site], moves[site]));
    };
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
        const auto corners = mesh.corners(t);
        if (std::ranges::all_of(corners, [&](std::uint32_t v) { return mesh.is_site(v); })) continue;
        for (std::uint32_t i = 0; i < 3; ++i) {
            const std::uint32_t h = Triangulation::edge(t, i), a = corners[i], b = corners[(i + 1) % 3];
            if (mesh.is_site(a) == mesh.is_site(b)) {
                const std::uint32_t apex = mesh.origin(Triangulation::previous(h));
                if (mesh.twin(h) != Triangulation::kNone || !mesh.is_site(apex)) continue;
                const Point along = mesh.along(h);
                const double area = cross(along, mesh.point(apex) - mesh.point(a)), squared = dot(along, along);
                if (is_far(apex, area * area / squared)) continue;
                const double side = std::sqrt(squared);
                keep_off(apex, 1 / side * Point{-along.y, along.x}, area / side);
            } else {
                const std::uint32_t site = mesh.is_site(a) ? a : b;
                const Point away = mesh.is_site(a) ? Point{} - mesh.along(h) : mesh.along(h);
                const double squared = dot(away, away);
                if (is_far(site, squared)) continue;
                const double distance = std::sqrt(squared);
                keep_off(site, 1 / distance * away, distance);
            }
        }
    }
}

}  // namespace ccdt
