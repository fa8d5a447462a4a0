// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/polish/mesh_transport.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/polish/error_grid.h"

namespace ccdt {

namespace {

constexpr std::uint32_t kNone = Triangulation::kNone;
// Number of sites or triangles per task.
constexpr std::size_t kSites = 4096, kTriangles = 8192;

double length(Point p) {
    return std::sqrt(dot(p, p));
}

/// Returns the site with which each vertex is merged [vertices]. A site is merged with itself. A border vertex is
/// merged with the nearest site that an edge joins to it, or else with the site of an adjacent border vertex. In a part
/// without sites, the entry is kNone.
std::vector<std::uint32_t> owners(const Triangulation& mesh) {
    struct Half {
        std::uint32_t from, to;
        double squared;
    };
    std::vector<Half> edges;  // all half-edges that end on the border
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
        const auto corners = mesh.corners(t);
        for (std::uint32_t i = 0; i < 3; ++i) {
            const std::uint32_t a = corners[i], b = corners[(i + 1) % 3];
            if (mesh.is_site(a) && mesh.is_site(b)) continue;
            const Point along = mesh.point(b) - mesh.point(a);
            if (!mesh.is_site(a)) edges.push_back({b, a, dot(along, along)});
            if (!mesh.is_site(b)) edges.push_back({a, b, dot(along, along)});
        }
    }
    std::vector<std::uint32_t> owner(mesh.vertex_count(), kNone);
    for (std::uint32_t v = 0; v < mesh.site_count(); ++v) owner[v] = v;
    std::vector<double> nearest(mesh.vertex_count());
    for (bool found = true; found;) {
        found = false;
        const std::vector<std::uint32_t> before = owner;
        for (const auto& [from, to, squared] : edges) {
            if (before[from] == kNone || before[to] != kNone) continue;
            if (owner[to] != kNone && squared >= nearest[to]) continue;
            owner[to] = before[from];
            nearest[to] = squared;
            found = true;
        }
        std::erase_if(edges, [&](const Half& edge) { return owner[edge.to] != kNone; });
    }
    return owner;
}

/// Lists the edges that `passes` accepts, with the conductances of linear finite elements. Border vertices are merged
/// with sites.
std::vector<GraphSolver::Edge> edges_between_sites(const Triangulation& mesh, const MeshTransport::Passes& passes) {
    // Bounds on conductances, which needles can exceed. At an edge of the border, two triangles can give a negative
    // value, which counts as no conductance.
    constexpr double kMin = 1e-3, kMax = 2;
    // Doubled area relative to squared sides. In thinner triangles, angles consist of rounding errors.
    constexpr double kThinnest = 1e-12;
    const auto owner = owners(mesh);
    // Cotangents of the angles opposite to the edges.
    std::vector<std::array<double, 3>> cotangents(mesh.triangle_count());
    for_ranges(mesh.executor(), cotangents.size(), kTriangles, [&](std::size_t begin, std::size_t end) {
        for (std::size_t t = begin; t < end; ++t) {
            const auto [a, b, c] = mesh.places(static_cast<std::uint32_t>(t));
            const Point ab = b - a, bc = c - b, ca = a - c;
            const double area = cross(ab, bc);
            const double scale = area > kThinnest * (dot(ab, ab) + dot(bc, bc)) ? -1 / area : 0;
            cotangents[t] = {scale * dot(bc, ca), scale * dot(ca, ab), scale * dot(ab, bc)};
        }
    });
    std::vector<std::vector<GraphSolver::Edge>> lists((cotangents.size() + kTriangles - 1) / kTriangles);
    for_ranges(mesh.executor(), cotangents.size(), kTriangles, [&](std::size_t begin, std::size_t end) {
        auto& list = lists[begin / kTriangles];
        list.reserve(3 * (end - begin) / 2 + 3);
        for (auto t = static_cast<std::uint32_t>(begin); t < end; ++t) {
            const auto corners = mesh.corners(t);
            for (std::uint32_t i = 0; i < 3; ++i) {
                const std::uint32_t h = Triangulation::edge(t, i), twin = mesh.twin(h);
                if (twin != kNone && twin < h) continue;
                const std::uint32_t a = owner[corners[i]], b = owner[corners[(i + 1) % 3]];
                if (a == b || a == kNone || b == kNone || !passes(a, b)) continue;
                const double other = twin == kNone ? 0 : cotangents[Triangulation::triangle_of(twin)][twin % 4];
                list.push_back({a, b, std::clamp((cotangents[t][i] + other) / 2, kMin, kMax)});
            }
        }
    });
    std::vector<GraphSolver::Edge> edges;
    edges.reserve(3 * mesh.site_count());
    for (const auto& list : lists) edges.insert(edges.end(), list.begin(), list.end());
    return edges;
}

/// Numbers the connected components and returns the number of each vertex' component [vertices].
std::vector<std::uint32_t> connected_parts(const GraphSolver& graph) {
    std::vector<std::uint32_t> part_of(graph.size(), kNone), reached;
    std::uint32_t parts = 0;
    for (std::uint32_t v = 0; v < part_of.size(); ++v) {
        if (part_of[v] != kNone) continue;
        part_of[v] = parts;
        reached.push_back(v);
        while (!reached.empty()) {
            const std::uint32_t from = reached.back();
            reached.pop_back();
            for (const GraphSolver::Link& link : graph.links(from)) {
                if (part_of[link.to] != kNone) continue;
                part_of[link.to] = parts;
                reached.push_back(link.to);
            }
        }
        ++parts;
    }
    return part_of;
}

/// Returns the borders of the parts that have sites. The weights are such that each part wants as many sites as it has.
std::vector<BorderEdge> border_of(const Domain& domain, const Density& density, const Triangulation& mesh) {
    const Point sides = domain.unit_bounds().max;
    const auto index = [](double share, int cells) {
        return std::clamp(static_cast<int>(share * cells), 0, cells - 1);
    };
    std::vector<double> wanted(mesh.part_count(), 0), held(mesh.part_count(), 0);
    for (std::uint32_t v = 0; v < mesh.site_count(); ++v) held[mesh.part_of(v)] += 1;
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
        const auto [a, b, c] = mesh.places(t);
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
    : executor_(mesh.executor()),
      solver_(mesh.site_count(), edges_between_sites(mesh, passes), mesh.executor()),
      measure_(std::move(measure)),
      error_(mesh.site_count()),
      potential_(mesh.site_count()),
      part_of_(connected_parts(solver_)),
      sums_(part_of_.empty() ? 0 : *std::ranges::max_element(part_of_) + 1),
      counts_(sums_.size()) {}

/// Computes the errors of the sites. Subtracts the mean error of each component: the measure smooths across gaps in the
/// domain, so this mean can differ from zero.
void MeshTransport::find_errors(const Triangulation& mesh) {
    // Limit on the error of a site. In a narrow tongue, a single missing site is most of the density, so the error is
    // too large for a solution to first order. Countries in core/README.md: with a third of this limit, waves of four
    // spacings in Canada are 5 dB stronger.
    constexpr double kMax = 0.3;
    measure_(std::span<const Point>(mesh.points()).first(mesh.site_count()), error_);
    std::ranges::fill(sums_, 0.0);
    std::ranges::fill(counts_, 0.0);
    for (std::uint32_t v = 0; v < mesh.site_count(); ++v) {
        error_[v] = std::clamp(error_[v], -kMax, kMax);
        sums_[part_of_[v]] += error_[v];
        counts_[part_of_[v]] += 1;
    }
    for (std::uint32_t v = 0; v < mesh.site_count(); ++v)
        error_[v] = sums_[part_of_[v]] / counts_[part_of_[v]] - error_[v];
}

/// Converts flows along edges to moves: each end of an edge moves by half the flow times the edge vector.
void MeshTransport::flow(const Triangulation& mesh, std::span<const double> spacings, std::span<Point> moves) const {
    constexpr double kMaxMove = 0.35;  // in spacings; 0.25 gives 1 dB more noise in fjords: countries in core/README.md
    for_ranges(executor_, mesh.site_count(), kSites, [&](std::size_t begin, std::size_t end) {
        for (auto v = static_cast<std::uint32_t>(begin); v < end; ++v) {
            Point move;
            for (const auto& [to, conductance] : solver_.links(v)) {
                const double flow = conductance * (potential_[to] - potential_[v]);
                move = move + (flow / 2) * (mesh.point(to) - mesh.point(v));
            }
            const double longest = kMaxMove * spacings[v], distance = length(move);
            moves[v] = distance > longest ? (longest / distance) * move : move;
        }
    });
}

bool MeshTransport::displacements(const Triangulation& mesh, std::span<const double> spacings, std::span<Point> moves,
                                  const std::stop_token& stop) {
    FirstRow row;
    row.find(mesh);
    return displacements(mesh, row, spacings, moves, stop);
}

bool MeshTransport::displacements(const Triangulation& mesh, const FirstRow& row, std::span<const double> spacings,
                                  std::span<Point> moves, const std::stop_token& stop) {
    constexpr int kSteps = 2;  // benchmark CountryPattern: twice as many steps gain a decibel where there are fjords
    if (stop.stop_requested()) return false;
    find_errors(mesh);
    if (stop.stop_requested()) return false;
    solver_.solve(error_, potential_, kSteps);
    if (stop.stop_requested()) return false;
    flow(mesh, spacings, moves);
    row.keep_off_vertices(mesh, spacings, kFirstRow, moves);
    row.keep_off_edges(mesh, spacings, kFirstRow, moves);
    return true;
}

}  // namespace ccdt
