// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/narrow_places.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <queue>
#include <utility>
#include <vector>

#include "core/ccdt/domain_mesh.h"
#include "core/geometry/predicates.h"
#include "core/polish/cell_list.h"

namespace ccdt {

namespace {

constexpr std::size_t kFewest = 3;  ///< least number of sites of a strip
constexpr std::uint32_t kNone = Triangulation::kNone;

/// A triangle of a narrow place.
struct Piece {
    std::array<Point, 3> corners;
    Point centre;
    double area = 0;
    double sites = 0;  ///< capacity, in sites
    std::vector<std::uint32_t> neighbours = {};

    bool contains(Point p) const {
        return orientation(corners[0], corners[1], p) >= 0 && orientation(corners[1], corners[2], p) >= 0 &&
               orientation(corners[2], corners[0], p) >= 0;
    }
};

/// Returns the width of the domain at a triangle of a border's mesh: the least height over an edge on the border, or if
/// there is none, the longest edge.
double width_at(const Triangulation& mesh, std::uint32_t t) {
    double width = std::numeric_limits<double>::infinity(), longest = 0;
    for (std::uint32_t i = 0; i < 3; ++i) {
        const Point edge = mesh.along(Triangulation::edge(t, i));
        const double length = std::sqrt(dot(edge, edge));
        if (mesh.triangles()[t].is_constrained(i)) width = std::min(width, mesh.doubled_area(t) / length);
        longest = std::max(longest, length);
    }
    return std::min(width, longest);
}

/// Returns the triangles of a border's mesh at which the domain is narrower than the spacing.
/// @param site  capacity of a site
std::vector<Piece> find_pieces(const Triangulation& mesh, const CapacityIntegral& capacity, double site) {
    constexpr double kNarrow = 1.1;  // largest width, in spacings
    constexpr double kEmpty = 1e-9;  // capacity that may be a rounding error, in sites
    std::vector<std::uint32_t> numbers(mesh.triangle_count(), kNone);
    std::vector<Piece> pieces;
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
        if (!mesh.triangles()[t].is_inside()) continue;
        const auto corners = mesh.places(t);
        const auto& [a, b, c] = corners;
        const double area = mesh.doubled_area(t) / 2;
        const double held =
            capacity.is_uniform() ? area : capacity.along(a, b) + capacity.along(b, c) + capacity.along(c, a);
        const Piece piece{corners, 1.0 / 3 * (a + b + c), area, std::max(0.0, held) / site};
        if (piece.sites < kEmpty || width_at(mesh, t) >= kNarrow * std::sqrt(area / piece.sites)) continue;
        numbers[t] = static_cast<std::uint32_t>(pieces.size());
        pieces.push_back(piece);
    }
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
        for (std::uint32_t i = 0; numbers[t] != kNone && i < 3; ++i) {
            if (mesh.triangles()[t].is_constrained(i)) continue;
            const std::uint32_t next = numbers[Triangulation::triangle_of(mesh.twin(Triangulation::edge(t, i)))];
            if (next != kNone) pieces[numbers[t]].neighbours.push_back(next);
        }
    }
    return pieces;
}

/// A connected set of narrow pieces.
class Strip {
public:
    /// @param walk  the pieces, in the order of a walk in depth from one end
    Strip(const std::vector<Piece>& pieces, std::vector<std::uint32_t> walk) : pieces_(pieces), walk_(std::move(walk)) {
        for (const std::uint32_t piece : walk_) all_ += pieces_[piece].sites;
    }

    /// Capacity, in sites.
    double all() const { return all_; }
    /// Mean spacing of sites.
    double spacing() const {
        double area = 0;
        for (const std::uint32_t piece : walk_) area += pieces_[piece].area;
        return std::sqrt(area / all_);
    }
    std::span<const std::uint32_t> walk() const { return walk_; }

    /// Returns positions for sites, in the order of the walk.
    /// @param owner, distance  scratch memory [pieces]
    std::vector<Point> distribute(std::size_t sites, std::vector<std::uint32_t>& owner,
                                  std::vector<double>& distance) const {
        constexpr int kRounds = 24;
        std::vector<std::uint32_t> at = equal_steps(sites);
        std::vector<Point> centres(sites);
        for (int round = 0; round < kRounds; ++round) {
            find_owners(at, owner, distance);
            std::vector<double> held(sites, 0);
            std::ranges::fill(centres, Point{});
            for (const std::uint32_t piece : walk_) {
                const std::uint32_t site = owner[piece];
                held[site] += pieces_[piece].sites;
                centres[site] = centres[site] + pieces_[piece].sites * pieces_[piece].centre;
            }
            for (std::size_t site = 0; site < sites; ++site) {
                centres[site] = held[site] > 0 ? 1 / held[site] * centres[site] : pieces_[at[site]].centre;
            }
            if (!move_to(centres, owner, at)) break;
        }
        for (std::size_t site = 0; site < sites; ++site) {
            if (!pieces_[at[site]].contains(centres[site])) centres[site] = pieces_[at[site]].centre;
        }
        return centres;
    }

private:
    /// Returns the pieces in which a walk through the strip has completed equal steps of capacity.
    std::vector<std::uint32_t> equal_steps(std::size_t sites) const {
        std::vector<std::uint32_t> at;
        const double step = all_ / static_cast<double>(sites);
        double done = 0;
        for (const std::uint32_t piece : walk_) {
            done += pieces_[piece].sites;
            if (at.size() < sites && done >= (static_cast<double>(at.size()) + 0.5) * step) at.push_back(piece);
        }
        while (at.size() < sites) at.push_back(walk_[at.size() % walk_.size()]);
        return at;
    }

    /// Assigns each piece to the nearest site. The distance of neighbouring pieces is the mean of their capacities.
    void find_owners(std::span<const std::uint32_t> at, std::vector<std::uint32_t>& owner,
                     std::vector<double>& distance) const {
        using Entry = std::pair<double, std::uint32_t>;  // distance, piece
        std::priority_queue<Entry, std::vector<Entry>, std::greater<>> queue;
        for (const std::uint32_t piece : walk_) distance[piece] = std::numeric_limits<double>::infinity();
        for (std::uint32_t site = 0; site < at.size(); ++site) {
            owner[at[site]] = site;
            distance[at[site]] = 0;
            queue.emplace(0, at[site]);
        }
        while (!queue.empty()) {
            const auto [length, piece] = queue.top();
            queue.pop();
            if (length > distance[piece]) continue;
            for (const std::uint32_t next : pieces_[piece].neighbours) {
                const double longer = length + (pieces_[piece].sites + pieces_[next].sites) / 2;
                if (longer >= distance[next]) continue;
                distance[next] = longer;
                owner[next] = owner[piece];
                queue.emplace(longer, next);
            }
        }
    }

    /// Moves each site to its piece that is nearest to a place.
    /// @returns  whether any site moved
    bool move_to(std::span<const Point> places, const std::vector<std::uint32_t>& owner,
                 std::vector<std::uint32_t>& at) const {
        const std::vector<std::uint32_t> before = at;
        std::vector<double> least(at.size(), std::numeric_limits<double>::infinity());
        for (const std::uint32_t piece : walk_) {
            const std::uint32_t site = owner[piece];
            const Point apart = pieces_[piece].centre - places[site];
            const double squared = pieces_[piece].contains(places[site]) ? -1 : dot(apart, apart);
            if (squared >= least[site]) continue;
            least[site] = squared;
            at[site] = piece;
        }
        return at != before;
    }

    const std::vector<Piece>& pieces_;
    std::vector<std::uint32_t> walk_;
    double all_ = 0;
};

/// Returns the pieces that are connected with a piece, in the order of a walk in depth that begins there.
std::vector<std::uint32_t> walk_from(const std::vector<Piece>& pieces, std::uint32_t first,
                                     std::vector<bool>& reached) {
    std::vector<std::uint32_t> walk, stack{first};
    while (!stack.empty()) {
        const std::uint32_t piece = stack.back();
        stack.pop_back();
        if (reached[piece]) continue;
        reached[piece] = true;
        walk.push_back(piece);
        stack.insert(stack.end(), pieces[piece].neighbours.begin(), pieces[piece].neighbours.end());
    }
    return walk;
}

/// Sites of a strip, and new places for them.
struct Row {
    std::vector<std::uint32_t> sites;
    std::vector<Point> places;
    double enough = 0;  ///< distance at which neighbours do not crowd
};

/// Returns a measure of how near the sites of a row are to each other and to other sites.
double crowding(const Row& row, std::span<const Point> places, const CellList& cells) {
    double sum = 0;
    for (const std::uint32_t site : row.sites) {
        double least = row.enough * row.enough;
        cells.for_near(places[site], row.enough, [&](Point p, std::uint32_t i) {
            const Point way = p - places[site];
            if (i != site) least = std::min(least, dot(way, way));
        });
        sum += 1 / least;
    }
    return sum;
}

/// Moves the sites of each row to their new places, unless this would increase their crowding considerably.
/// @returns  whether any site moved
bool move_rows(const Domain& domain, std::span<const Row> rows, std::span<Point> sites) {
    constexpr double kIncrease = 1.2;  // for example of sites on both sides of a sharp bend
    const std::vector<Point> before(sites.begin(), sites.end());
    const CellList old_cells(domain, before);
    std::vector<const Row*> moved;
    for (const Row& row : rows) {
        moved.push_back(&row);
        for (std::size_t i = 0; i < row.sites.size(); ++i) sites[row.sites[i]] = row.places[i];
    }
    for (bool reverted = true; reverted;) {
        const CellList cells(domain, sites);
        reverted = std::erase_if(moved, [&](const Row* row) {
                       if (crowding(*row, sites, cells) <= kIncrease * crowding(*row, before, old_cells)) return false;
                       for (const std::uint32_t site : row->sites) sites[site] = before[site];
                       return true;
                   }) > 0;
    }
    return !moved.empty();
}

}  // namespace

bool has_narrow_places(const Triangulation& mesh) {
    std::size_t narrow = 0;
    for (std::uint32_t site = 0; site < mesh.site_count(); ++site) {
        int sites = 0, borders = 0, changes = 0;
        bool first = false, last = false;
        mesh.for_edges(site, [&](std::uint32_t h) {
            const bool is_site = mesh.is_site(mesh.target(h));
            if (sites + borders == 0)
                first = is_site;
            else if (is_site != last)
                ++changes;
            last = is_site;
            ++(is_site ? sites : borders);
        });
        if (first != last) ++changes;
        if (sites == 0 || changes >= 4) ++narrow;
    }
    return narrow >= kFewest;
}

bool even_out_narrow_places(const Domain& domain, const CapacityIntegral& capacity, std::span<Point> sites, double site,
                            const std::stop_token& stop) {
    constexpr double kEnough = 0.85;   // in spacings
    constexpr std::size_t kFine = 16;  // number of sites per site for which vertices on the border are close enough
    const auto mesh = empty_mesh(domain, make_border(domain, capacity, kFine * sites.size()), 1, stop);
    if (!mesh || stop.stop_requested()) return false;
    const std::vector<Piece> pieces = find_pieces(mesh->mesh, capacity, site);
    const CellList cells(domain, sites);
    std::vector<std::uint32_t> owner(pieces.size());
    std::vector<double> distance(pieces.size());
    std::vector<bool> tried(pieces.size()), reached(pieces.size());
    std::vector<Row> rows;
    for (std::uint32_t piece = 0; piece < pieces.size() && !stop.stop_requested(); ++piece) {
        if (tried[piece]) continue;
        // The last piece of a walk is at an end of the strip, from which the final walk begins.
        const std::uint32_t end = walk_from(pieces, piece, tried).back();
        const Strip strip(pieces, walk_from(pieces, end, reached));
        if (strip.all() < kFewest) continue;
        Row row;
        for (const std::uint32_t number : strip.walk()) {
            const Piece& part = pieces[number];
            double reach = 0;
            for (const Point corner : part.corners)
                reach = std::max(reach, dot(corner - part.centre, corner - part.centre));
            cells.for_near(part.centre, std::sqrt(reach), [&](Point p, std::uint32_t i) {
                if (part.contains(p)) row.sites.push_back(i);
            });
        }
        std::ranges::sort(row.sites);
        row.sites.erase(std::unique(row.sites.begin(), row.sites.end()), row.sites.end());
        if (row.sites.size() < kFewest) continue;
        row.enough = kEnough * strip.spacing();
        row.places = strip.distribute(row.sites.size(), owner, distance);
        rows.push_back(std::move(row));
    }
    return !stop.stop_requested() && !rows.empty() && move_rows(domain, rows, sites);
}

}  // namespace ccdt
