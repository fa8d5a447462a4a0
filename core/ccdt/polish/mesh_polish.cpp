// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/polish/mesh_polish.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "core/ccdt/polish/push.h"
#include "core/geometry/hexagonal_spacing.h"
#include "core/mesh/edge_list.h"

namespace ccdt {

namespace {

/// Longest push, in spacings. Even if two neighbours of a hexagonal grid, 1.07 spacings apart, move straight towards
/// each other, they keep more than half of their distance.
constexpr double kMaxPush = 0.2;
/// Least distance from the border, in spacings, to which a push with a reach of at most 1 may move a site. With a
/// smaller value, sites get stuck together in needles, and with a larger one in narrow places: test
/// Polish.LeavesNoNearPairsAtNeedles. A push with a longer reach would press sites against the border, so it uses
/// kFirstRow instead.
constexpr double kBorderDepth = 0.1;
constexpr std::size_t kSites = 8192;  ///< sites per task

}  // namespace

MeshPolish::MeshPolish(const Domain& domain, const Density& density, double capacity, std::size_t sites,
                       const Support& support, FixedSites fixed, const std::stop_token& stop, Executor& executor)
    : executor_(executor), domain_(domain), density_(density), fixed_(std::move(fixed)), support_(support) {
    if (!(fixed_.sites > 0)) fixed_.sites = static_cast<double>(sites);
    if (!fixed_.others.empty()) others_.emplace(domain, fixed_.others);
    if (domain.is_box()) {
        transport_.emplace(domain, density, static_cast<std::size_t>(std::llround(fixed_.sites)), stop, executor);
    } else if (!density.is_uniform()) {
        local_.emplace(domain.unit_bounds().max, density, fixed_.sites * density.total() / capacity);
    }
}

double MeshPolish::spacing(Point p) const {
    if (transport_) return transport_->spacing(p);
    if (local_) return local_->at(p);
    return std::sqrt(domain_.unit_area() / fixed_.sites);
}

/// Returns the nearest point of the domain's bounding box; on a torus, returns p, snapped to multiples of 2^-50.
Point MeshPolish::inside(Point p) const {
    constexpr double kInside = 1e-9;
    const Point sides = domain_.unit_bounds().max;
    if (domain_.is_torus()) return snapped(p);
    return {std::clamp(p.x, kInside * sides.x, (1 - kInside) * sides.x),
            std::clamp(p.y, kInside * sides.y, (1 - kInside) * sides.y)};
}

/// Returns the position nearest to `to` at which a site may lie: in the domain's bounding box, in the site's zone of
/// the density, and where the density is not 0. If the density has one zone and there is no such position within two
/// spacings, the density is ignored.
/// @param from     current position of the site
/// @param spacing  returns the local spacing; called only if needed
template <class Spacing>
Point MeshPolish::allowed(Point from, Point to, Spacing&& spacing) const {
    constexpr double kReach = 2;  // in spacings
    to = inside(to);
    if (density_.is_uniform()) return to;
    if (support_.zones() > 1) return inside(support_.nearest_in_zone(from, to));
    const Point corner = support_.box_corner(to), position = to - corner;
    const auto here = support_.inset_in_cell(position);
    if (here == position) return to;
    return inside(corner + (here ? *here : support_.nearest(position, kReach * spacing())));
}

void MeshPolish::even_out_start(std::span<Point> sites, const std::stop_token& stop) {
    // Fewer rounds leave a larger error of tone: benchmark PictureTone. In free rounds, sites may stand where there is
    // no density. Without free rounds, or without momentum, too few sites cross white gaps: test
    // Polish.EvensOutSmallSpots.
    constexpr int kRounds = 5, kFreeRounds = 3;
    constexpr double kMomentum = 0.5;
    if (density_.is_uniform() || !transport_) return;
    moves_.resize(sites.size() + fixed_.positions.size());
    std::vector<Point> last(sites.size()), all;
    for (int round = 0; round < kRounds; ++round) {
        if (!fixed_.positions.empty()) {
            all.assign(sites.begin(), sites.end());
            all.insert(all.end(), fixed_.positions.begin(), fixed_.positions.end());
        }
        if (!transport_->displacements(all.empty() ? sites : all, moves_, stop, fixed_.weights)) break;
        const bool free = round < kFreeRounds;
        for_ranges(executor_, sites.size(), kSites, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                last[i] = moves_[i] + (free ? kMomentum : 0) * last[i];
                const Point moved = sites[i] + last[i];
                sites[i] = free && support_.zones() == 1 ? inside(moved)
                                                         : allowed(sites[i], moved, [&] { return spacing(sites[i]); });
            }
        });
    }
    for (Point& p : sites) p = p - support_.box_corner(p);
}

void MeshPolish::release_memory() {
    if (transport_) transport_->release_memory();
    moves_ = std::vector<Point>();
    spacings_ = std::vector<double>();
}

void MeshPolish::begin(const Triangulation& mesh) {
    moves_.resize(mesh.site_count());
    // In polygons, FirstRow needs the spacings of all sites.
    if (!density_.is_uniform() || !domain_.is_box()) spacings_.resize(mesh.site_count());
    const SiteBlocks& blocks = mesh.blocks();
    std::vector<std::vector<std::uint32_t>> others(blocks.count(0));
    edges_.resize(static_cast<std::size_t>(blocks.levels()));
    for (int level = 0; level < blocks.levels(); ++level)
        edges_[static_cast<std::size_t>(level)].assign(blocks.count(level), {});
    executor_.run(others.size(), [&](std::size_t block) { list_edges(mesh, block, others[block]); });
    for (const auto& list : others) {
        for (const std::uint32_t h : list) {
            const auto block = blocks.around({mesh.origin(h), mesh.target(h)});
            edges_[static_cast<std::size_t>(block.level)][block.number].push_back(h);
        }
    }
    if (!domain_.is_box()) row_.find(mesh);
    guard_ = {};
}

/// Lists the edges between sites in the range of triangles with the number `block`. Stores edges within the block of
/// this number in edges_, and other edges in `others`.
void MeshPolish::list_edges(const Triangulation& mesh, std::size_t block, std::vector<std::uint32_t>& others) {
    const SiteBlocks& blocks = mesh.blocks();
    const std::size_t count = blocks.count(0);
    const std::uint32_t first = blocks.begin(block), size = blocks.begin(block + 1) - first;
    const std::size_t begin = block * mesh.triangle_count() / count, end = (block + 1) * mesh.triangle_count() / count;
    const auto is_free_edge = [&](std::uint32_t h, std::uint32_t twin) {
        const std::uint32_t a = mesh.origin(h), b = mesh.target(h);
        return std::size_t{twin != Triangulation::kNone} & std::size_t{twin > h} &
               std::size_t{mesh.is_site(std::max(a, b))} & std::size_t{mesh.is_free(std::min(a, b))};
    };
    std::vector<std::uint32_t> own(3 * (end - begin));
    own.resize(ccdt::list_edges(mesh, begin, end, own, is_free_edge));
    const auto is_within = [&](std::uint32_t h) {
        return mesh.origin(h) - first < size && mesh.target(h) - first < size;
    };
    const auto rest = std::stable_partition(own.begin(), own.end(), is_within);
    others.assign(rest, own.end());
    edges_[0][block].assign(own.begin(), rest);
}

void MeshPolish::even_out(Triangulation& mesh, const std::stop_token& stop) {
    if (transport_) {
        const std::span<const Point> sites = std::span<const Point>(mesh.points()).first(mesh.site_count());
        if (transport_->displacements(sites, moves_, stop, fixed_.weights)) apply(mesh);
    } else if (density_.is_smooth() && fixed_.positions.empty() && fixed_.others.empty()) {
        if (!mesh_transport_) mesh_transport_.emplace(domain_, density_, mesh);
        measure_spacings(mesh);
        if (mesh_transport_->displacements(mesh, row_, spacings_, moves_, stop)) apply(mesh);
    }
}

bool MeshPolish::find_nearer(const Triangulation& mesh, double least) {
    measure_spacings(mesh);
    const double half_reach = 0.5 * least * hexagonal_spacing(1);
    if (!domain_.is_box()) find_facing(mesh, half_reach);
    const auto is_near = [&](std::uint32_t h) { return is_nearer(mesh, mesh.origin(h), mesh.target(h), half_reach); };
    const auto has_near = [&](const std::vector<std::uint32_t>& list) { return std::ranges::any_of(list, is_near); };
    return !facing_.empty() ||
           std::ranges::any_of(edges_, [&](const auto& blocks) { return std::ranges::any_of(blocks, has_near); });
}

std::vector<std::array<std::uint32_t, 2>> MeshPolish::near_pairs(const Triangulation& mesh, double least) {
    auto pairs = joined_within(mesh, 0.5 * least * hexagonal_spacing(1));
    pairs.insert(pairs.end(), facing_.begin(), facing_.end());
    mesh_transport_.reset();
    std::ranges::sort(pairs);
    std::vector<std::array<std::uint32_t, 2>> taken;
    const auto is_taken = [&](std::uint32_t site) {
        return std::ranges::any_of(taken, [&](const auto& pair) { return pair[0] == site; });
    };
    for (const auto& pair : pairs) {
        if (!is_taken(pair[0]) && !is_taken(pair[1])) taken.push_back(pair);
    }
    return taken;
}

/// Lists the pairs of near sites that are joined by an edge, the smaller number first.
/// @param half_reach  half of the distance below which two sites are near, relative to the mean of their spacings
std::vector<std::array<std::uint32_t, 2>> MeshPolish::joined_within(const Triangulation& mesh,
                                                                    double half_reach) const {
    std::vector<std::array<std::uint32_t, 2>> joined;
    const auto join = [&](std::uint32_t h) {
        const std::uint32_t a = mesh.origin(h), b = mesh.target(h);
        if (is_nearer(mesh, a, b, half_reach)) joined.push_back({std::min(a, b), std::max(a, b)});
    };
    for (const auto& blocks : edges_) {
        for (const auto& list : blocks) std::ranges::for_each(list, join);
    }
    return joined;
}

bool MeshPolish::is_nearer(const Triangulation& mesh, std::uint32_t a, std::uint32_t b, double half_reach) const {
    const Point apart = mesh.point(b) - mesh.point(a);
    const double reach = half_reach * (spacing_of(a) + spacing_of(b));
    return dot(apart, apart) < reach * reach;
}

/// Lists the pairs of near sites that no edge joins. Only sites of the first row can form such pairs.
void MeshPolish::find_facing(const Triangulation& mesh, double half_reach) {
    facing_.clear();
    const auto sites = row_.sites();
    if (sites.empty()) return;
    std::vector<Point> positions;
    for (const std::uint32_t site : sites) positions.push_back(mesh.point(site));
    const CellList cells(domain_, positions);
    for (const std::uint32_t a : sites) {
        cells.for_near(mesh.point(a), 2 * half_reach * spacing_of(a), [&](Point, std::uint32_t number) {
            const std::uint32_t b = sites[number];
            if (a < b && is_nearer(mesh, a, b, half_reach)) facing_.push_back({a, b});
        });
    }
    if (facing_.empty()) return;
    std::ranges::sort(facing_);
    auto joined = joined_within(mesh, half_reach);
    std::ranges::sort(joined);
    std::vector<std::array<std::uint32_t, 2>> others;
    std::ranges::set_difference(facing_, joined, std::back_inserter(others));
    facing_ = std::move(others);
}

void MeshPolish::measure_spacings(const Triangulation& mesh) {
    if (density_.is_uniform()) {
        even_spacing_ = spacing({});
        std::ranges::fill(spacings_, even_spacing_);
        return;
    }
    for_ranges(executor_, mesh.site_count(), kSites, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) spacings_[v] = spacing(mesh.points()[v]);
    });
}

void MeshPolish::remove_low_frequencies(Triangulation& mesh, const std::stop_token& stop) {
    if (!stealth_) stealth_.emplace(domain_, mesh.site_count(), executor_);
    const std::span<const Point> sites = std::span<const Point>(mesh.points()).first(mesh.site_count());
    if (stealth_->displacements(sites, moves_, stop)) apply(mesh);
}

void MeshPolish::move(Triangulation& mesh, std::span<const Point> moves) {
    std::ranges::copy(moves, moves_.begin());
    apply(mesh);
}

void MeshPolish::push_apart(Triangulation& mesh, double reach, double push, std::span<const Point> pushed,
                            const std::stop_token& stop) {
    constexpr double kStuck = 0.6;  // relative to the reach; after a push or two, only sites that are stuck are nearer
    const double half_reach = 0.5 * reach * hexagonal_spacing(1);
    measure_spacings(mesh);
    std::fill(moves_.begin(), moves_.end(), Point{});
    std::ranges::copy(pushed, moves_.begin());
    const auto push_two = [&](std::uint32_t a, std::uint32_t b, Point along) {
        const double least = half_reach * (spacing_of(a) + spacing_of(b));
        const double squared = dot(along, along);
        if (squared >= least * least) return;
        // Two sites that face each other across a narrow tongue would be pressed against the borders of the tongue. So
        // they also turn around each other.
        const bool turns = !domain_.is_box() && squared < kStuck * kStuck * least * least;
        const Point way = turns ? Point{along.x - along.y, along.x + along.y} : along;
        const Point by = PairPush{least, push}.move(way, std::sqrt(squared));
        // If one of the two sites is fixed, the other site moves the whole way.
        moves_[a] = moves_[a] - (mesh.is_free(b) ? 1 : 2) * by;
        moves_[b] = moves_[b] + (mesh.is_free(a) ? 1 : 2) * by;
    };
    for (const auto& blocks : edges_) {
        executor_.run(blocks.size(), [&](std::size_t block) {
            for (const std::uint32_t h : blocks[block]) push_two(mesh.origin(h), mesh.target(h), mesh.along(h));
        });
    }
    for (const auto& [a, b] : facing_) push_two(a, b, mesh.point(b) - mesh.point(a));
    if (others_) push_off_others(mesh, half_reach, push);
    for_ranges(executor_, moves_.size(), kSites, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
            moves_[v] = capped(moves_[v], kMaxPush * spacing_of(static_cast<std::uint32_t>(v)));
        }
    });
    if (!domain_.is_box()) {
        const bool presses = reach > 1;
        if (presses) row_.keep_off_vertices(mesh, spacings_, kFirstRow, moves_);
        row_.keep_off_edges(mesh, spacings_, presses ? kFirstRow : kBorderDepth, moves_);
    }
    if (!stop.stop_requested()) apply(mesh);
}

/// Pushes sites away from fixed points that have no vertex.
/// @param half_reach  half of the distance below which a push acts, relative to the spacing of the site
void MeshPolish::push_off_others(const Triangulation& mesh, double half_reach, double push) {
    const Point sides = domain_.unit_bounds().max;
    for (std::uint32_t v = 0; v < mesh.free_count(); ++v) {
        const double least = 2 * half_reach * spacing_of(v);
        const Point site = mesh.is_torus() ? wrapped(mesh.point(v), sides) : mesh.point(v);
        moves_[v] = pushed_off(*others_, site, least, moves_[v], [&](std::uint32_t, double) {
            return PairPush{least, 2 * push};
        });
    }
}

void MeshPolish::apply(Triangulation& mesh) {
    constexpr double kSmall = 0.05;  // relative to the mean area; larger triangles are no needles
    for (auto v = static_cast<std::uint32_t>(mesh.free_count()); v < mesh.site_count(); ++v) moves_[v] = mesh.point(v);
    for_ranges(executor_, mesh.free_count(), kSites, [&](std::size_t begin, std::size_t end) {
        for (std::size_t v = begin; v < end; ++v) {
            const Point here = mesh.points()[v], there = here + moves_[v];
            mesh.points()[v] =
                density_.is_uniform() ? inside(there) : allowed(here, there, [&] { return spacing(here); });
            moves_[v] = here;
        }
    });
    // In polygons, vertices of the border leave less space to move.
    const int halvings = domain_.is_box() ? 0 : 3;
    const double small = kSmall * domain_.unit_area() / static_cast<double>(mesh.site_count());
    guard_.check(mesh, moves_, domain_.resolution(), halvings,
                 [=](std::uint32_t, double area) { return area >= small; });
    if (mesh.is_torus()) mesh.wrap();
}

}  // namespace ccdt
