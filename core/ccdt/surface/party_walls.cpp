// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/surface/party_walls.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <utility>

namespace ccdt {

namespace {

constexpr std::uint32_t kNone = ~std::uint32_t{0};

/// Faces that are connected by edges of two faces.
struct Patch {
    std::vector<std::uint32_t> faces;
    std::vector<std::pair<std::uint32_t, bool>> border;  ///< edges, and whether they run towards the higher vertex
    std::uint32_t match = kNone;                         ///< patch on the other side of a wall
};

class WallFinder {
public:
    WallFinder(std::span<const Point3> positions, std::span<const WallFace> faces, std::span<const CrowdedSide> sides)
        : positions_(positions), faces_(faces), sides_(sides), patch_of_(faces.size(), kNone) {
        for (const CrowdedSide& side : sides) {
            if (patch_of_[side.half_edge / 4] == kNone) collect(side.half_edge / 4);
        }
        for (const auto& [edge, half_edge] : sides) {
            const auto& corners = faces[half_edge / 4].corners;
            const bool is_upward = corners[half_edge % 4] < corners[(half_edge % 4 + 1) % 3];
            patches_[patch_of_[half_edge / 4]].border.emplace_back(edge, is_upward);
        }
    }

    std::vector<std::uint32_t> walls() {
        match();
        drop_free_walls();
        std::vector<std::uint32_t> walls;
        for (const Patch& patch : patches_) {
            if (patch.match != kNone) walls.insert(walls.end(), patch.faces.begin(), patch.faces.end());
        }
        return walls;
    }

private:
    void collect(std::uint32_t first) {
        const auto number = static_cast<std::uint32_t>(patches_.size());
        Patch& patch = patches_.emplace_back();
        patch.faces.push_back(first);
        patch_of_[first] = number;
        for (std::size_t i = 0; i < patch.faces.size(); ++i) {
            for (const std::uint32_t twin : faces_[patch.faces[i]].twins) {
                if (twin == kNone || patch_of_[twin / 4] != kNone) continue;
                patch_of_[twin / 4] = number;
                patch.faces.push_back(twin / 4);
            }
        }
    }

    std::array<Point3, 3> positions(std::uint32_t face) const {
        const auto& [a, b, c] = faces_[face].corners;
        return {positions_[a], positions_[b], positions_[c]};
    }

    /// Whether all faces of a patch are in one plane, with the same orientation.
    bool is_plane(const Patch& patch) const {
        constexpr double kThickness = 1e-9;
        const auto normal_of = [this](std::uint32_t face) {
            const auto [a, b, c] = positions(face);
            return cross(b - a, c - a);
        };
        Point3 normal{};
        for (const std::uint32_t face : patch.faces) normal = normal + normal_of(face);
        const Point3 origin = positions(patch.faces.front())[0];
        const double most = kThickness * length(normal);
        return most > 0 && std::ranges::all_of(patch.faces, [&](std::uint32_t face) {
                   return dot(normal_of(face), normal) >= 0 && std::ranges::all_of(positions(face), [&](Point3 p) {
                              return std::abs(dot(p - origin, normal)) <= most;
                          });
               });
    }

    /// Matches plane patches that have the same border in opposite directions. If more than two have it, none matches.
    void match() {
        std::vector<std::uint32_t> order;
        for (std::uint32_t i = 0; i < patches_.size(); ++i) {
            std::ranges::sort(patches_[i].border);
            if (is_plane(patches_[i])) order.push_back(i);
        }
        const auto edges_differ = [this](std::uint32_t a, std::uint32_t b) {
            return std::ranges::lexicographical_compare(patches_[a].border, patches_[b].border, {},
                                                        &std::pair<std::uint32_t, bool>::first,
                                                        &std::pair<std::uint32_t, bool>::first);
        };
        std::ranges::stable_sort(order, edges_differ);
        for (std::size_t begin = 0, end = 0; begin < order.size(); begin = end) {
            while (end < order.size() && !edges_differ(order[begin], order[end])) ++end;
            if (end - begin != 2) continue;
            Patch &a = patches_[order[begin]], &b = patches_[order[begin + 1]];
            const bool is_opposite = std::ranges::equal(
                a.border, b.border, [](const auto& u, const auto& v) { return u.second != v.second; });
            if (!is_opposite) continue;
            a.match = order[begin + 1];
            b.match = order[begin];
        }
    }

    /// Drops the matches of walls that do not end everywhere at two other parts. A wall ends freely at an edge that it
    /// does not share with exactly two other faces, or that it shares with two faces of one patch, as at the border of
    /// a sheet. Walls without any border are dropped, too.
    void drop_free_walls() {
        std::vector<std::uint32_t> parents(patches_.size());
        std::iota(parents.begin(), parents.end(), 0U);
        const auto root = [&parents](std::uint32_t i) {
            while (parents[i] != i) i = parents[i] = parents[parents[i]];
            return i;
        };
        std::vector<std::uint8_t> is_attached(patches_.size()), is_free(patches_.size());
        std::vector<std::uint32_t> walls, others;
        for (std::size_t begin = 0, end = 0; begin < sides_.size(); begin = end) {
            walls.clear();
            others.clear();
            for (; end < sides_.size() && sides_[end].edge == sides_[begin].edge; ++end) {
                const std::uint32_t patch = patch_of_[sides_[end].half_edge / 4];
                (patches_[patch].match == kNone ? others : walls).push_back(patch);
            }
            const bool has_two_parts = others.size() == 2 && others[0] != others[1];
            for (const std::uint32_t wall : walls) {
                if (others.empty())
                    parents[root(wall)] = root(walls.front());
                else
                    (has_two_parts ? is_attached : is_free)[wall] = 1;
            }
        }
        for (std::uint32_t i = 0; i < patches_.size(); ++i) {
            if (patches_[i].match != kNone) parents[root(i)] = root(patches_[i].match);
        }
        for (std::uint32_t i = 0; i < patches_.size(); ++i) {
            is_attached[root(i)] |= is_attached[i];
            is_free[root(i)] |= is_free[i];
        }
        for (std::uint32_t i = 0; i < patches_.size(); ++i) {
            if (is_attached[root(i)] == 0 || is_free[root(i)] != 0) patches_[i].match = kNone;
        }
    }

    std::span<const Point3> positions_;
    std::span<const WallFace> faces_;
    std::span<const CrowdedSide> sides_;
    std::vector<std::uint32_t> patch_of_;  ///< [faces]
    std::vector<Patch> patches_;
};

}  // namespace

std::vector<std::uint32_t> party_walls(std::span<const Point3> positions, std::span<const WallFace> faces,
                                       std::span<const CrowdedSide> sides) {
    return WallFinder(positions, faces, sides).walls();
}

}  // namespace ccdt
