// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/polish/mesh_transport.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/ccdt/polish/error_grid.h"
#include "core/ccdt/polish/site_graph.h"

namespace ccdt {

namespace {

constexpr std::uint32_t kNone = Triangulation::kNone;
constexpr std::size_t kSites = 4096;  ///< sites per task

/// Returns the borders of the parts that have sites. The weights are such that each part wants as many sites as it has.
std::vector<BorderEdge> border_of(const Domain& domain, const Density& density, const Triangulation& mesh) {
    const Point sides = domain.unit_bounds().max;
    const auto index = [](double share, int cells) {
        return std::clamp(static_cast<int>(share * cells), 0, cells - 1);
    };
    std::vector<double> wanted(mesh.part_count(), 0), held(mesh.part_count(), 0);
    for (std::uint32_t v = 0; v < mesh.site_count(); ++v) held[mesh.part_of(v)] += 1;
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
        const auto [a, b, c] = mesh.positions(t);
        const Point middle = 1.0 / 3 * (a + b + c);
        const double value = density.is_uniform() ? 1
                                                  : density.value(index(middle.x / sides.x, density.width()),
                                                                  index(middle.y / sides.y, density.height()));
        wanted[mesh.part_of(mesh.corners(t)[0])] += value * mesh.doubled_area(t);
    }
    std::vector<BorderEdge> border;
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
        const std::uint32_t part = mesh.part_of(mesh.corners(t)[0]);
        for (std::uint32_t i = 0; i < 3; ++i) {
            const std::uint32_t h = Triangulation::edge(t, i);
            if (mesh.twin(h) != kNone || held[part] == 0) continue;
            const double weight = wanted[part] > 0 ? held[part] / wanted[part] : 0;
            border.push_back({mesh.point(mesh.origin(h)), mesh.point(mesh.target(h)), weight});
        }
    }
    return border;
}

/// Returns the cell size of the error grid: the spacing where sites are sparsest, but at most twice the mean spacing.
double cell_of(const Domain& domain, const Density& density, std::size_t sites) {
    constexpr double kMax = 2;
    const double mean = std::sqrt(domain.unit_area() / static_cast<double>(sites));
    if (density.is_uniform()) return mean;
    double least = density.largest();
    for (int row = 0; row < density.height(); ++row) {
        for (int column = 0; column < density.width(); ++column) {
            if (density.value(column, row) > 0) least = std::min(least, density.value(column, row));
        }
    }
    const double cells = static_cast<double>(density.width()) * density.height();
    return std::clamp(std::sqrt(density.total() / cells / least), 1.0, kMax) * mean;
}

}  // namespace

MeshTransport::MeshTransport(const Domain& domain, const Density& density, const Triangulation& mesh)
    : MeshTransport(
          mesh,
          [grid = ErrorGrid(domain.unit_bounds().max, cell_of(domain, density, mesh.site_count()), mesh.site_count(),
                            border_of(domain, density, mesh), density),
           &executor = mesh.executor()](std::span<const Point> sites, std::span<double> errors) mutable {
              grid.measure(sites);
              for_ranges(executor, sites.size(), kSites, [&](std::size_t begin, std::size_t end) {
                  for (std::size_t v = begin; v < end; ++v) errors[v] = grid.at(sites[v]);
              });
          },
          [](std::uint32_t, std::uint32_t) { return true; }) {}

MeshTransport::MeshTransport(const Triangulation& mesh, Measure measure, const Passes& passes)
    : flow_(mesh.site_count(), edges_between_sites(mesh, passes), mesh.executor()), measure_(std::move(measure)) {}

bool MeshTransport::displacements(const Triangulation& mesh, std::span<const double> spacings, std::span<Point> moves,
                                  const std::stop_token& stop) {
    FirstRow row;
    row.find(mesh);
    return displacements(mesh, row, spacings, moves, stop);
}

bool MeshTransport::displacements(const Triangulation& mesh, const FirstRow& row, std::span<const double> spacings,
                                  std::span<Point> moves, const std::stop_token& stop) {
    if (stop.stop_requested()) return false;
    measure_(std::span<const Point>(mesh.points()).first(mesh.site_count()), flow_.errors());
    if (!flow_.solve(stop)) return false;
    flow_.moves([&](std::uint32_t v, std::uint32_t to) { return mesh.point(to) - mesh.point(v); }, spacings, moves);
    row.keep_off_vertices(mesh, spacings, kFirstRow, moves);
    row.keep_off_edges(mesh, spacings, kFirstRow, moves);
    return true;
}

}  // namespace ccdt
