// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/relax/border.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/hexagonal_spacing.h"

namespace ccdt {

namespace {

/// Divides the edge ab into equal steps, about one per crossed cell. Returns the lengths from a to the end of each step
/// [steps + 1], in hexagonal distances of sites; the first entry is 0.
std::vector<double> spacings_along(Point a, Point b, const CapacityIntegral& capacity, double sites_per_capacity) {
    const int samples = capacity.cells_along(a, b);
    const double step = std::sqrt(dot(b - a, b - a)) / samples;
    std::vector<double> sums{0};
    for (int i = 0; i < samples; ++i) {
        const double density = sites_per_capacity * capacity.at(a + ((i + 0.5) / samples) * (b - a));
        sums.push_back(sums.back() + (density > 0 ? step / hexagonal_spacing(density) : 0));
    }
    return sums;
}

/// Returns the number of parts into which an edge is divided. An edge shorter than the spacing is not divided.
long parts_of(double length_in_sites) {
    return std::max(1L, std::lround(length_in_sites));
}

/// Returns the number of vertices to add on the domain's edges so that vertices are as far apart as neighbouring
/// sites.
double wanted_vertices(const Domain& domain, const LengthInSites& length) {
    double sum = 0;
    for (const Ring& ring : domain.rings()) {
        for (std::size_t i = 0; i < ring.size(); ++i)
            sum += static_cast<double>(parts_of(length(ring[i], ring[(i + 1) % ring.size()]).back()) - 1);
    }
    return sum;
}

}  // namespace

Border make_border(const Domain& domain, const CapacityIntegral& capacity, std::size_t sites) {
    const double sites_per_capacity = static_cast<double>(sites) / capacity.total();
    return make_border(
        domain, [&](Point a, Point b) { return spacings_along(a, b, capacity, sites_per_capacity); }, sites);
}

Border make_border(const Domain& domain, const LengthInSites& length, std::size_t sites) {
    // In a domain thinner than the spacing, sites are farther apart along the border than one spacing. There, one
    // vertex per site makes the sites more even than more vertices would, and keeps the mesh small.
    const double most = static_cast<double>(sites) + 64;
    const double wanted = wanted_vertices(domain, length);
    const double thinning = wanted > most ? most / wanted : 1;
    Border border;
    for (const Ring& ring : domain.rings()) {
        std::vector<Point>& loop = border.loops.emplace_back();
        for (std::size_t i = 0; i < ring.size(); ++i) {
            const Point a = ring[i], b = ring[(i + 1) % ring.size()];
            loop.push_back(a);
            border.corner.push_back(true);
            const auto sums = length(a, b);
            const long count = parts_of(thinning * sums.back());
            const auto samples = static_cast<double>(sums.size() - 1);
            std::size_t k = 0;
            for (long j = 1; j < count; ++j) {
                const double level = sums.back() * static_cast<double>(j) / static_cast<double>(count);
                while (sums[k + 1] < level) ++k;
                const double at = (static_cast<double>(k) + (level - sums[k]) / (sums[k + 1] - sums[k])) / samples;
                const Point p = a + at * (b - a);
                if (p == loop.back() || p == b) continue;
                loop.push_back(p);
                border.corner.push_back(false);
            }
        }
    }
    return border;
}

Border bare_border(const Domain& domain) {
    return {domain.rings(), std::vector<bool>(domain.corner_count(), true)};
}

tl::expected<ConstrainedDelaunay, SegmentConflict> triangulate(const Border& border, const std::stop_token& stop) {
    std::vector<Point> points;
    std::vector<Segment> segments;
    for (const auto& loop : border.loops) {
        const auto first = static_cast<std::uint32_t>(points.size());
        const auto size = static_cast<std::uint32_t>(loop.size());
        for (std::uint32_t i = 0; i < size; ++i) segments.push_back({first + i, first + (i + 1) % size});
        points.insert(points.end(), loop.begin(), loop.end());
    }
    auto scaffold = constrained_delaunay(points, segments, stop);
    if (!scaffold) return scaffold;
    for (std::uint32_t i = 0; i < scaffold->vertex_of.size(); ++i) {
        const std::uint32_t vertex = scaffold->vertex_of[i];
        if (vertex != i && !(border.corner[i] && border.corner[vertex])) return tl::unexpected(SegmentConflict{i});
    }
    return scaffold;
}

}  // namespace ccdt
