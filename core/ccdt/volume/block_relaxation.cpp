// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/volume/block_relaxation.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <utility>

#include "core/base/elementary.h"
#include "core/base/random.h"
#include "core/ccdt/relax/relaxation.h"
#include "core/mesh/move_guard.h"

namespace ccdt {

namespace {

/// Largest number of sites in a block. Larger blocks have smaller rims, but need more memory.
constexpr std::size_t kMaxSites = 10000;
/// Largest number of copies of these sites, which only thin domains exceed. Their blocks have fewer sites.
constexpr std::size_t kMaxCopies = 2 * kMaxSites;
constexpr std::size_t kMinBlocks = 2;  ///< allows two threads to share the work if there are few sites
/// Share of the sites on the lower side of the first planes in odd calls, whose blocks thus have other borders.
constexpr double kOddShare = 0.4;
constexpr int kOddPlanes = 3;
/// Width of the rim around a block whose sites are triangulated with it, in spacings. Almost all tetrahedra with a
/// corner in the block are those of the complete triangulation.
constexpr double kRim = 1.75;
constexpr double kMaxMove = 0.4;  ///< longest move, in spacings
constexpr double kOffset = 1e-9;  ///< largest offset of copies, in the unit frame

/// The face of a tetrahedron that is opposite to a site. The site is on the left of the face, as the last corner of a
/// Tetrahedron is on the left of the first three.
using Face = std::array<std::uint32_t, 3>;

/// The faces opposite to each site.
struct Fans {
    std::vector<std::uint32_t> begins;  ///< [sites + 1]
    std::vector<Face> faces;
    std::vector<double> weights;  ///< [faces] density of the face's tetrahedron; empty if it is uniform
};

Fans fans_of(std::span<const Tetrahedron> tetrahedra, std::size_t sites) {
    constexpr std::array<std::array<std::size_t, 3>, 4> kOpposite{{{1, 3, 2}, {0, 2, 3}, {0, 3, 1}, {0, 1, 2}}};
    Fans fans;
    fans.begins.assign(sites + 1, 0);
    for (const Tetrahedron& corners : tetrahedra) {
        for (const std::uint32_t corner : corners) {
            if (corner < sites) ++fans.begins[corner];
        }
    }
    std::uint32_t sum = 0;
    for (std::uint32_t& begin : fans.begins) begin = sum += begin;
    fans.faces.resize(sum);
    for (const Tetrahedron& corners : tetrahedra) {
        for (std::size_t i = 0; i < 4; ++i) {
            if (corners[i] >= sites) continue;
            const auto& [a, b, c] = kOpposite[i];
            fans.faces[--fans.begins[corners[i]]] = {corners[a], corners[b], corners[c]};
        }
    }
    return fans;
}

/// A symmetric 3 x 3 system of equations.
struct Equations {
    double xx = 0, xy = 0, xz = 0, yy = 0, yz = 0, zz = 0;
    Point3 right;

    void add(Point3 gradient, double excess) {
        xx += gradient.x * gradient.x;
        xy += gradient.x * gradient.y;
        xz += gradient.x * gradient.z;
        yy += gradient.y * gradient.y;
        yz += gradient.y * gradient.z;
        zz += gradient.z * gradient.z;
        right = right - excess * gradient;
    }
    void add_spring(double stiffness, Point3 to_middle) {
        xx += stiffness;
        yy += stiffness;
        zz += stiffness;
        right = right + stiffness * to_middle;
    }
    Point3 solve() const {
        const Point3 a{xx, xy, xz}, b{xy, yy, yz}, c{xz, yz, zz};
        const Point3 bc = cross(b, c), ca = cross(c, a), ab = cross(a, b);
        const double determinant = dot(a, bc);
        if (!(determinant > 0)) return {};
        return (1 / determinant) * (right.x * bc + right.y * ca + right.z * ab);
    }
};

}  // namespace

template <class Domain>
double BlockRelaxation<Domain>::relax(std::span<Point3> sites, std::size_t free, int passes,
                                      const std::stop_token& stop) {
    const std::vector<Block> blocks = divide(sites);
    ++calls_;
    std::vector<Point3> moved(sites.begin(), sites.begin() + static_cast<std::ptrdiff_t>(free));
    std::vector<Sums> sums(blocks.size());
    executor_.run(blocks.size(), [&](std::size_t number) {
        sums[number] = relax_block(blocks[number], sites, free, passes, moved, stop);
    });
    if (stop.stop_requested()) return 0;
    std::ranges::copy(moved, sites.begin());
    Sums all;
    for (const Sums& part : sums) {
        all.count += part.count;
        all.first += part.first;
        all.second += part.second;
    }
    if (!(all.first > 0)) return 0;  // all capacities are below the least number
    const double mean = all.first / all.count;
    return std::sqrt(std::max(0.0, all.second / all.count - mean * mean)) / mean;
}

/// Divides the domain into blocks of up to kMaxSites sites with about kMaxCopies copies.
template <class Domain>
std::vector<typename BlockRelaxation<Domain>::Block> BlockRelaxation<Domain>::divide(
    std::span<const Point3> sites) const {
    Block all;
    all.own.resize(sites.size());
    std::iota(all.own.begin(), all.own.end(), 0U);
    for (const Point3 site : sites) {
        const auto reach = static_cast<float>(kRim * spacing_.side(site));
        domain_.for_copies(site, reach, [&](Point3 copy, bool is_original) {
            if (!is_original) all.near.push_back({copy, reach});
        });
    }
    std::vector<Block> blocks;
    const std::size_t most = std::min({kMaxSites, (sites.size() + kMinBlocks - 1) / kMinBlocks,
                                       kMaxCopies * sites.size() / std::max<std::size_t>(1, all.near.size())});
    divide(std::move(all), sites, most, calls_ % 2 == 1 ? kOddPlanes : 0, blocks);
    return blocks;
}

/// Divides a block by planes across the longest side of its bounding box until no part has more than `most` sites.
/// @param odd_planes  number of recursions that divide the sites unequally
template <class Domain>
void BlockRelaxation<Domain>::divide(Block block, std::span<const Point3> sites, std::size_t most, int odd_planes,
                                     std::vector<Block>& blocks) const {
    Box3 box{sites[block.own.front()], sites[block.own.front()]};
    for (const std::uint32_t i : block.own) box = bounds_of(std::array{box.min, box.max, sites[i]});
    const Point3 size = box.max - box.min;
    const std::size_t axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    if (block.own.size() <= most || !(along(size, axis) > 0)) {
        blocks.push_back(std::move(block));
        return;
    }
    std::vector<double> coordinates;
    coordinates.reserve(block.own.size());
    for (const std::uint32_t i : block.own) coordinates.push_back(along(sites[i], axis));
    const double share = odd_planes > 0 ? kOddShare : 0.5;
    const auto middle = static_cast<std::ptrdiff_t>(share * static_cast<double>(coordinates.size()));
    std::ranges::nth_element(coordinates, coordinates.begin() + middle);
    // The plane is above the lowest site, so no part is empty.
    const double lowest = along(box.min, axis), highest = along(box.max, axis);
    const double plane = std::max(coordinates[static_cast<std::size_t>(middle)], std::nextafter(lowest, highest));
    Block low, high;
    for (const std::uint32_t i : block.own) {
        const double above = along(sites[i], axis) - plane;
        const auto reach = static_cast<float>(kRim * spacing_.side(sites[i]));
        (above < 0 ? low : high).own.push_back(i);
        if (std::abs(above) < reach) (above < 0 ? high : low).near.push_back({sites[i], reach});
    }
    for (const Neighbour& near : block.near) {
        const double above = along(near.position, axis) - plane;
        if (above < near.reach) low.near.push_back(near);
        if (above > -near.reach) high.near.push_back(near);
    }
    block = {};
    divide(std::move(low), sites, most, odd_planes - 1, blocks);
    divide(std::move(high), sites, most, odd_planes - 1, blocks);
}

template <class Domain>
typename BlockRelaxation<Domain>::Sums BlockRelaxation<Domain>::relax_block(const Block& block,
                                                                            std::span<const Point3> sites,
                                                                            std::size_t free, int passes,
                                                                            std::span<Point3> moved,
                                                                            const std::stop_token& stop) const {
    const std::size_t own = block.own.size();
    Sums sums;
    if (own == 0 || stop.stop_requested()) return sums;
    std::vector<Point3> positions;
    positions.reserve(own + block.near.size());
    for (const std::uint32_t i : block.own) positions.push_back(sites[i]);
    // In a box, two sites and their mirror images at one face lie on a circle. Tiny offsets of the copies avoid the
    // exact arithmetic that such cases need.
    for (const Neighbour& near : block.near) {
        Random random(0, positions.size());
        const double offset = kOffset * random.uniform();
        positions.push_back(domain_.periodic ? near.position : near.position + Point3{offset, -offset, 2 * offset});
    }
    Fans fans = fans_of(delaunay_tetrahedra(positions, stop), own);
    if (stop.stop_requested() || fans.faces.empty()) return sums;
    const auto capacity_of = [&](std::size_t site, std::size_t k) {
        const auto& [a, b, c] = fans.faces[k];
        const double volume =
            dot(cross(positions[b] - positions[a], positions[c] - positions[a]), positions[site] - positions[a]) / 6;
        return fans.weights.empty() ? volume : fans.weights[k] * volume;
    };
    if (!density_.is_uniform()) {
        const Point3 sides = domain_.sides;
        fans.weights.resize(fans.faces.size());
        for (std::size_t site = 0; site < own; ++site) {
            for (std::size_t k = fans.begins[site]; k < fans.begins[site + 1]; ++k) {
                const auto& [a, b, c] = fans.faces[k];
                const Point3 middle = 0.25 * (positions[a] + positions[b] + positions[c] + positions[site]);
                double sum = 0;
                for (const Point3 corner : {positions[a], positions[b], positions[c], positions[site], middle}) {
                    const Point3 p = domain_.in_box(0.5 * (corner + middle));
                    sum += density_.at({p.x / sides.x, p.y / sides.y, p.z / sides.z});
                }
                fans.weights[k] = sum / 5;
            }
        }
    }
    for (std::size_t site = 0; site < own; ++site) {
        for (std::size_t k = fans.begins[site]; k < fans.begins[site + 1]; ++k) {
            const double capacity = capacity_of(site, k);
            sums.first += capacity;
            sums.second += capacity * capacity;
        }
    }
    sums.count = static_cast<double>(fans.faces.size());

    const double even = domain_.volume() / static_cast<double>(sites.size());  // mean capacity per site
    const double goal = even * 4 * static_cast<double>(own) / sums.count;
    std::vector<Point3> gradients;
    std::vector<double> capacities;
    for (int pass = 0; pass < passes && !stop.stop_requested(); ++pass) {
        for (std::uint32_t site = 0; site < own; ++site) {
            if (block.own[site] >= free) continue;
            const Point3 position = positions[site];
            const std::size_t begin = fans.begins[site], count = fans.begins[site + 1] - begin;
            if (count == 0) continue;
            gradients.resize(count);
            capacities.resize(count);
            Equations equations;
            Point3 middle;
            double mean_weight = 0;
            for (std::size_t k = 0; k < count; ++k) {
                const auto& [a, b, c] = fans.faces[begin + k];
                const Point3 to_a = positions[a] - position, to_b = positions[b] - position,
                             to_c = positions[c] - position;
                const double weight = fans.weights.empty() ? 1 : fans.weights[begin + k];
                gradients[k] = (weight / 6) * cross(to_b - to_a, to_c - to_a);
                capacities[k] = -dot(gradients[k], to_a);
                equations.add(gradients[k], capacities[k] - goal);
                middle = middle + to_a + to_b + to_c;
                mean_weight += weight;
            }
            const auto faces = static_cast<double>(count);
            // A site with f opposite faces has f / 2 + 2 neighbours, by Euler's formula.
            const double stiffness = kSpring * elementary::pow(even, 4.0 / 3) * (faces / 2 + 2);
            const double local = fans.weights.empty() ? 1 : elementary::pow(mean_weight / faces, 2.0 / 3);
            equations.add_spring(local * stiffness, 1 / (3 * faces) * middle);
            Point3 move = kRelaxation * equations.solve();
            const double size = length(move), longest = kMaxMove * spacing_.side(domain_.in_box(position));
            if (size > longest) move = longest / size * move;
            double share = 1;
            for (std::size_t k = 0; k < count; ++k) {
                const double change = dot(gradients[k], move), least = (kKeptShare - 1) * capacities[k];
                if (change * share < least) share = least / change;
            }
            positions[site] = position + share * move;
        }
    }
    for (std::size_t site = 0; site < own; ++site) {
        const std::uint32_t i = block.own[site];
        if (i < free) moved[i] = domain_.moved(sites[i], positions[site]);
    }
    return sums;
}

template class BlockRelaxation<BoxDomain3>;
template class BlockRelaxation<SolidDomain>;

}  // namespace ccdt
