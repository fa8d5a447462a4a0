// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <queue>
#include <span>
#include <stop_token>
#include <utility>
#include <vector>

#include "core/geometry/point.h"
#include "core/geometry/point3.h"
#include "core/geometry/predicates.h"

// Rows of sites where a domain in the plane, or a surface, is narrower than the spacing. A mesh is a Triangulation or a
// SurfaceTriangulation. A position is a Point or a Point3.
namespace ccdt {

inline constexpr std::size_t kMinInRow = 3;  ///< least number of sites of a row

inline bool is_in_triangle(const std::array<Point, 3>& corners, Point p) {
    return orientation(corners[0], corners[1], p) >= 0 && orientation(corners[1], corners[2], p) >= 0 &&
           orientation(corners[2], corners[0], p) >= 0;
}
/// Whether the projection of a point to the plane of a triangle lies in the triangle.
inline bool is_in_triangle(const std::array<Point3, 3>& corners, Point3 p) {
    const auto& [a, b, c] = corners;
    const Point3 normal = cross(b - a, c - a);
    return dot(cross(b - a, p - a), normal) >= 0 && dot(cross(c - b, p - b), normal) >= 0 &&
           dot(cross(a - c, p - c), normal) >= 0;
}

/// A triangle of a narrow place.
template <class Position>
struct NarrowPiece {
    std::array<Position, 3> corners;
    Position centre;
    double area = 0;
    double sites = 0;                                              ///< capacity, in sites
    std::array<std::uint32_t, 3> neighbours{kNone, kNone, kNone};  ///< across its edges

    static constexpr std::uint32_t kNone = ~std::uint32_t{0};

    bool contains(Position p) const { return is_in_triangle(corners, p); }
};

/// Whether several sites lie where the domain is narrower than their spacing: the border is next to such a site on two
/// opposite sides. O(sites).
/// @param mesh  trimmed, not of a torus
template <class Mesh>
bool has_narrow_places(const Mesh& mesh) {
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
    return narrow >= kMinInRow;
}

/// Returns the triangles of a border's mesh at which the domain is narrower than the spacing. The width of the domain
/// at a triangle is the least height over an edge on the border, or if there is none, the longest edge.
/// @param mesh       its vertices lie on the border
/// @param sites_in   returns the capacity of a triangle, in sites; 0 for triangles that do not count
/// @param on_border  returns whether an edge is on the border
template <class Mesh, class SitesIn, class OnBorder>
auto find_narrow_pieces(const Mesh& mesh, SitesIn&& sites_in, OnBorder&& on_border) {
    constexpr double kNarrow = 1.1;  // largest width, in spacings
    constexpr double kEmpty = 1e-9;  // capacity that may be a rounding error, in sites
    using Position = decltype(mesh.along(0));
    std::vector<std::uint32_t> numbers(mesh.triangle_count(), Mesh::kNone);
    std::vector<double> capacities;  // [pieces]
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
        const double sites = sites_in(t), doubled_area = mesh.doubled_area(t);
        if (!(sites >= kEmpty)) continue;
        double width = std::numeric_limits<double>::infinity(), longest = 0;
        for (std::uint32_t i = 0; i < 3; ++i) {
            const std::uint32_t edge = Mesh::edge(t, i);
            const Position along = mesh.along(edge);
            const double length = std::sqrt(dot(along, along));
            if (on_border(edge)) width = std::min(width, doubled_area / length);
            longest = std::max(longest, length);
        }
        if (std::min(width, longest) >= kNarrow * std::sqrt(doubled_area / 2 / sites)) continue;
        numbers[t] = static_cast<std::uint32_t>(capacities.size());
        capacities.push_back(sites);
    }
    std::vector<NarrowPiece<Position>> pieces;
    pieces.reserve(capacities.size());  // exact, because pieces are large
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
        if (numbers[t] == Mesh::kNone) continue;
        const auto corners = mesh.positions(t);
        const Position centre = 1.0 / 3 * (corners[0] + corners[1] + corners[2]);
        pieces.push_back({corners, centre, mesh.doubled_area(t) / 2, capacities[numbers[t]]});
    }
    for (std::uint32_t t = 0; t < mesh.triangle_count(); ++t) {
        for (std::uint32_t i = 0; numbers[t] != Mesh::kNone && i < 3; ++i) {
            const std::uint32_t edge = Mesh::edge(t, i);
            if (on_border(edge)) continue;
            pieces[numbers[t]].neighbours[i] = numbers[Mesh::triangle_of(mesh.twin(edge))];
        }
    }
    return pieces;
}

/// A connected set of narrow pieces.
template <class Position>
class NarrowStrip {
public:
    /// @param walk  the pieces, in the order of a depth-first walk from one end
    NarrowStrip(const std::vector<NarrowPiece<Position>>& pieces, std::vector<std::uint32_t> walk)
        : pieces_(pieces), walk_(std::move(walk)) {
        for (const std::uint32_t piece : walk_) all_ += pieces_[piece].sites;
    }

    /// Returns the capacity, in sites.
    double all() const { return all_; }
    /// Returns the mean spacing of sites.
    double spacing() const {
        double area = 0;
        for (const std::uint32_t piece : walk_) area += pieces_[piece].area;
        return std::sqrt(area / all_);
    }
    std::span<const std::uint32_t> walk() const { return walk_; }

    /// Returns positions for sites, in the order of the walk.
    /// @param owner, distance  scratch memory [pieces]
    std::vector<Position> distribute(std::size_t sites, std::vector<std::uint32_t>& owner,
                                     std::vector<double>& distance) const {
        constexpr int kRounds = 24;
        if (auto positions = along_line(sites, owner, distance)) return *std::move(positions);
        std::vector<std::uint32_t> at = equal_steps(sites);
        std::vector<Position> centres(sites);
        for (int round = 0; round < kRounds; ++round) {
            find_owners(at, owner, distance);
            std::vector<double> held(sites, 0);
            std::ranges::fill(centres, Position{});
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
    static constexpr std::uint32_t kNone = NarrowPiece<Position>::kNone;

    /// Returns positions at equal steps of capacity on the line through the middles of the edges between successive
    /// pieces. In a triangle, capacity grows linearly along this line. Returns none if the strip has branches.
    /// @param order, held  scratch memory [pieces]
    std::optional<std::vector<Position>> along_line(std::size_t sites, std::vector<std::uint32_t>& order,
                                                    std::vector<double>& held) const {
        constexpr double kBranch = 0.5;  // least capacity of a branch, in sites
        const auto count = static_cast<std::uint32_t>(walk_.size());
        for (const std::uint32_t piece : walk_) {
            order[piece] = kNone;
            held[piece] = pieces_[piece].sites;
        }
        std::vector<std::uint32_t> parent(count, 0), heaviest(count, kNone);  // in the walk, which is a tree
        std::size_t links = 0;
        for (std::uint32_t i = 0; i < count; ++i) {
            for (const std::uint32_t next : pieces_[walk_[i]].neighbours) {
                if (next == kNone || order[next] == kNone) continue;
                parent[i] = std::max(parent[i], order[next]);
                ++links;
            }
            order[walk_[i]] = i;
        }
        if (links > count) return std::nullopt;  // several loops
        for (std::uint32_t i = count - 1; i > 0; --i) {
            std::uint32_t& child = heaviest[parent[i]];
            if (child == kNone || held[walk_[child]] < held[walk_[i]]) child = i;
            held[walk_[parent[i]]] += held[walk_[i]];
        }
        const double step = all_ / static_cast<double>(sites);
        std::vector<Position> positions;
        double done = 0;
        Position from = middle_between(walk_.front(), walk_.back());
        for (std::uint32_t i = 0; i != kNone; i = heaviest[i]) {
            const std::uint32_t piece = walk_[i], next = walk_[heaviest[i] == kNone ? 0 : heaviest[i]];
            const double own = held[piece] - (heaviest[i] == kNone ? 0 : held[next]);  // with its short branches
            if (own - pieces_[piece].sites > kBranch * step) return std::nullopt;
            const Position to = middle_between(piece, next);
            for (double at = 0;
                 positions.size() < sites && (at = (static_cast<double>(positions.size()) + 0.5) * step) <= done + own;)
                positions.push_back(from + (at - done) / own * (to - from));
            done += own;
            from = to;
        }
        positions.resize(sites, from);
        return positions;
    }

    /// Returns the middle of the edge between two pieces; if there is none, the centre of the first one.
    Position middle_between(std::uint32_t piece, std::uint32_t next) const {
        const NarrowPiece<Position>& at = pieces_[piece];
        for (std::size_t i = 0; i < 3; ++i) {
            if (walk_.size() > 2 && at.neighbours[i] == next) return 0.5 * (at.corners[i] + at.corners[(i + 1) % 3]);
        }
        return at.centre;
    }

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
                if (next == kNone) continue;
                const double longer = length + (pieces_[piece].sites + pieces_[next].sites) / 2;
                if (longer >= distance[next]) continue;
                distance[next] = longer;
                owner[next] = owner[piece];
                queue.emplace(longer, next);
            }
        }
    }

    /// Moves each site to the piece of its own that is nearest to its position in `positions`.
    /// @param owner  [pieces] site of each piece
    /// @param at     in and out [sites] piece at which each site lies
    /// @returns  whether any site moved
    bool move_to(std::span<const Position> positions, const std::vector<std::uint32_t>& owner,
                 std::vector<std::uint32_t>& at) const {
        const std::vector<std::uint32_t> before = at;
        std::vector<double> least(at.size(), std::numeric_limits<double>::infinity());
        for (const std::uint32_t piece : walk_) {
            const std::uint32_t site = owner[piece];
            const Position apart = pieces_[piece].centre - positions[site];
            const double squared = pieces_[piece].contains(positions[site]) ? -1 : dot(apart, apart);
            if (squared >= least[site]) continue;
            least[site] = squared;
            at[site] = piece;
        }
        return at != before;
    }

    const std::vector<NarrowPiece<Position>>& pieces_;
    std::vector<std::uint32_t> walk_;
    double all_ = 0;
};

/// Returns the pieces that are connected with a piece, in the order of a depth-first walk that begins there.
template <class Position>
std::vector<std::uint32_t> walk_from(const std::vector<NarrowPiece<Position>>& pieces, std::uint32_t first,
                                     std::vector<bool>& reached) {
    std::vector<std::uint32_t> walk, stack{first};
    while (!stack.empty()) {
        const std::uint32_t piece = stack.back();
        stack.pop_back();
        if (reached[piece]) continue;
        reached[piece] = true;
        walk.push_back(piece);
        for (const std::uint32_t next : pieces[piece].neighbours) {
            if (next != NarrowPiece<Position>::kNone) stack.push_back(next);
        }
    }
    return walk;
}

/// Sites of a strip, and new positions for them.
template <class Position>
struct NarrowRow {
    std::vector<std::uint32_t> sites;
    std::vector<Position> positions;
    double enough = 0;  ///< distance at which neighbours do not crowd
};

/// Returns a measure of how near the sites of a row are to each other and to other sites.
/// @param is_apart  see move_rows()
template <class Position, class Cells, class IsApart>
double crowding(const NarrowRow<Position>& row, std::span<const Position> positions, const Cells& cells,
                const IsApart& is_apart) {
    double sum = 0;
    for (const std::uint32_t site : row.sites) {
        double least = row.enough * row.enough;
        cells.for_near(positions[site], row.enough, [&](Position p, std::uint32_t i) {
            const Position way = p - positions[site];
            if (i != site && !is_apart(site, i)) least = std::min(least, dot(way, way));
        });
        sum += least > 0 ? 1 / least : std::numeric_limits<double>::infinity();
    }
    return sum;
}

/// Moves the sites of each row to their new positions, unless this would increase their crowding considerably.
/// @param cells_of  returns the cell list of positions
/// @param is_apart  returns whether two sites cannot crowd each other, however near they are
/// @returns         whether each site is in a row that moved [sites]; empty if no row moved
template <class Position, class CellsOf, class IsApart>
std::vector<std::uint8_t> move_rows(std::span<const NarrowRow<Position>> rows, std::span<Position> sites,
                                    CellsOf&& cells_of, const IsApart& is_apart) {
    constexpr double kIncrease = 1.2;  // for example of sites on both sides of a sharp bend
    const std::vector<Position> before(sites.begin(), sites.end());
    const auto old_cells = cells_of(std::span<const Position>(before));
    std::vector<const NarrowRow<Position>*> moved;
    for (const NarrowRow<Position>& row : rows) {
        moved.push_back(&row);
        for (std::size_t i = 0; i < row.sites.size(); ++i) sites[row.sites[i]] = row.positions[i];
    }
    for (bool reverted = true; reverted;) {
        const auto cells = cells_of(std::span<const Position>(sites));
        reverted = std::erase_if(moved, [&](const NarrowRow<Position>* row) {
                       const double now = crowding<Position>(*row, sites, cells, is_apart);
                       if (now <= kIncrease * crowding<Position>(*row, before, old_cells, is_apart)) return false;
                       for (const std::uint32_t site : row->sites) sites[site] = before[site];
                       return true;
                   }) > 0;
    }
    if (moved.empty()) return {};
    std::vector<std::uint8_t> is_moved(sites.size(), 0);
    for (const NarrowRow<Position>* row : moved) {
        for (const std::uint32_t site : row->sites) is_moved[site] = 1;
    }
    return is_moved;
}

/// Returns the rows of all strips that have several sites.
/// @param sites_of  returns the sites in the pieces of a walk
/// @param stop      polled once per strip
template <class Position, class SitesOf>
std::vector<NarrowRow<Position>> narrow_rows(const std::vector<NarrowPiece<Position>>& pieces, SitesOf&& sites_of,
                                             const std::stop_token& stop) {
    constexpr double kEnough = 0.85;    // in spacings
    constexpr double kRounding = 1e-3;  // of the capacity of a thin strip, whose coordinates are rounded
    std::vector<std::uint32_t> owner(pieces.size());
    std::vector<double> distance(pieces.size());
    std::vector<bool> tried(pieces.size()), reached(pieces.size());
    std::vector<NarrowRow<Position>> rows;
    for (std::uint32_t piece = 0; piece < pieces.size() && !stop.stop_requested(); ++piece) {
        if (tried[piece]) continue;
        // The last piece of a walk is at an end of the strip, from which the final walk begins.
        const std::uint32_t end = walk_from(pieces, piece, tried).back();
        const NarrowStrip strip(pieces, walk_from(pieces, end, reached));
        if (strip.all() < kMinInRow * (1 - kRounding)) continue;
        NarrowRow<Position> row;
        row.sites = sites_of(strip.walk());
        if (row.sites.size() < kMinInRow) continue;
        row.enough = kEnough * strip.spacing();
        row.positions = strip.distribute(row.sites.size(), owner, distance);
        rows.push_back(std::move(row));
    }
    return rows;
}

}  // namespace ccdt
