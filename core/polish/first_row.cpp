#include "core/polish/first_row.h"

#include <algorithm>
#include <cmath>

namespace ccdt {

namespace {

double length(Point p) {
    return std::sqrt(dot(p, p));
}

}  // namespace

void keep_off_border(const Triangulation& mesh, std::span<const double> spacings, double depth,
                     std::span<Point> moves) {
    const auto keep_off = [&](std::uint32_t site, Point away, double distance) {
        const double least = std::min(distance, depth * spacings[site]), left = distance + dot(moves[site], away);
        if (left < least) moves[site] = moves[site] + (least - left) * away;
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
                const double side = length(along);
                keep_off(apex, 1 / side * Point{-along.y, along.x},
                         cross(along, mesh.point(apex) - mesh.point(a)) / side);
            } else {
                const std::uint32_t site = mesh.is_site(a) ? a : b;
                const Point away = mesh.is_site(a) ? Point{} - mesh.along(h) : mesh.along(h);
                keep_off(site, 1 / length(away) * away, length(away));
            }
        }
    }
}

}  // namespace ccdt
