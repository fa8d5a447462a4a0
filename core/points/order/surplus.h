// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <type_traits>
#include <vector>

#include "core/base/lanes.h"
#include "core/geometry/spreading.h"
#include "core/points/order/point_box.h"

namespace ccdt::ordering {

/// Factor of the spline weights in space, relative to the plane. Along the normal of a surface, each point adds its
/// weights to the nodes of a line, and reads them with the same weights. The sum of the squared weights is 11/20 on
/// average. With this factor, points on a flat surface have the same surplus as in the plane.
inline constexpr float kSpaceFactor = 1.3484F;  // 1 / sqrt(11/20)

/// Measures the surplus of points around a point: the actual number minus the wanted number, both smoothed by quadratic
/// B-splines on the nodes of a square grid. The surplus suppresses long waves, which the distances of neighbours do not
/// reveal. In space the grid is cubic, and the two sides of a thin plate have a common surplus.
template <class P>
class Surplus {
public:
    /// @param reference  points with the wanted density, up to a common factor
    /// @param points     actual points, numbered from 0
    /// @param distance   distance of nodes
    Surplus(const PointBox<P>& frame, std::span<const P> reference, std::span<const P> points, double distance)
        : is_torus_(frame.is_torus),
          factor_(kInSpace<P> && !frame.is_solid ? kSpaceFactor : 1),
          x_(frame.sides.x, distance, is_torus_),
          y_(frame.sides.y, distance, is_torus_) {
        if constexpr (kInSpace<P>) z_ = Axis(frame.sides.z, distance, is_torus_);
        wanted_.resize(z_.nodes * y_.nodes * x_.nodes);
        actual_.resize(wanted_.size());
        const float per_reference = 1 / static_cast<float>(reference.size());
        for (const P p : reference) add(around(p), per_reference, wanted_);
        around_.reserve(points.size());
        for (const P p : points) {
            around_.push_back(around(p));
            add(around_.back(), 1, actual_);
        }
        if (is_torus_) {
            join(wanted_);
            join(actual_);
        }
    }

    /// Returns the smoothed number of points that are wanted around a point, divided by the number of all points.
    float wanted(std::uint32_t point) const { return read(around_[point], wanted_); }

    /// Returns the smoothed number of points that are around a point.
    float actual(std::uint32_t point) const { return read(around_[point], actual_); }

    void remove(std::uint32_t point) {
        const Around& at = around_[point];
        if (!is_torus_ || !(x_.repeats(at.column) || y_.repeats(at.row) || z_.repeats(layer_of(at))))
            return add(at, -1, actual_);
        for_layers(at, [&](std::size_t layer, float share) {
            for_taps(b_spline<2>(at.x), b_spline<2>(at.y), share, [&](std::size_t j, std::size_t i, float each) {
                lower({at.column + i, at.row + j, layer_of(at) + layer}, each);
            });
        });
    }

private:
    /// Nodes along one side, at the centres of the cells and of one further cell beyond each end. On a torus, nodes a
    /// period apart are identical.
    struct Axis {
        Axis() = default;
        Axis(double length, double distance, bool torus)
            : cells(std::max(1.0, std::floor(length / distance))),
              cells_per_length(cells / length),
              nodes(static_cast<std::size_t>(cells) + 2),
              period(torus ? nodes - 2 : nodes) {}

        /// Returns the cell of a position.
        /// @param position  position as a length on entry; on return the offset in the cell, in units of cells
        std::size_t cell(double& position) const {
            position = std::clamp(position * cells_per_length, 0.0, cells);
            const double cell = std::min(std::floor(position), cells - 1);
            position -= cell;
            return static_cast<std::size_t>(cell);
        }

        /// Whether some of the three nodes around a position in a cell of a torus are identical to other nodes.
        bool repeats(std::size_t cell) const { return nodes > 1 && (cell < 2 || cell + 2 >= period); }

        double cells = 1;
        double cells_per_length = 0;
        std::size_t nodes = 1, period = 1;
    };

    /// Position along the third axis of the grid, like `column` and `x` of Around.
    struct Depth {
        std::uint32_t layer = 0;
        float z = 0;
    };
    struct Nothing {};

    /// The nodes around a position: nine in the plane, 27 in space. `column` and `row` are those of the node at the
    /// lower left. `x` and `y` are the offset of the position in the cell of the middle node, in [0, 1].
    struct Around {
        std::uint32_t column, row;
        float x, y;
        [[no_unique_address]] std::conditional_t<kInSpace<P>, Depth, Nothing> depth;
    };

    Around around(P p) const {
        Around at{};
        at.column = static_cast<std::uint32_t>(x_.cell(p.x));
        at.row = static_cast<std::uint32_t>(y_.cell(p.y));
        at.x = static_cast<float>(p.x);
        at.y = static_cast<float>(p.y);
        if constexpr (kInSpace<P>) {
            at.depth.layer = static_cast<std::uint32_t>(z_.cell(p.z));
            at.depth.z = static_cast<float>(p.z);
        }
        return at;
    }

    static std::size_t layer_of(const Around& at) {
        if constexpr (kInSpace<P>) return at.depth.layer;
        return 0;
    }

    /// Calls function(layer, share) for each layer of nodes around a position. `layer` counts from the first of these.
    template <class Function>
    CCDT_INLINE void for_layers(const Around& at, Function&& function) const {
        if constexpr (kInSpace<P>) {
            const std::array<float, 3> shares = b_spline<2>(at.depth.z);
            for (std::size_t k = 0; k < shares.size(); ++k) function(k, factor_ * shares[k]);
        } else {
            function(0, 1.0F);
        }
    }

    /// Returns the index of the first of the nine nodes around a position in a layer.
    std::size_t first_node(const Around& at, std::size_t layer) const {
        return ((layer_of(at) + layer) * y_.nodes + at.row) * x_.nodes + at.column;
    }

    float read(const Around& at, const std::vector<float>& nodes) const {
        const std::array<float, 3> x = b_spline<2>(at.x), y = b_spline<2>(at.y);
        float sum = 0;
        for_layers(at, [&](std::size_t layer, float share) CCDT_INLINE {
            const float* const first = nodes.data() + first_node(at, layer);
            sum += share * sum_taps(x, y, [&](std::size_t row) { return first + row * x_.nodes; });
        });
        return sum;
    }

    /// Adds the spline weights of a position, multiplied by `factor`, to the nodes around it.
    void add(const Around& at, float factor, std::vector<float>& nodes) const {
        const std::array<float, 3> x = b_spline<2>(at.x), y = b_spline<2>(at.y);
        for_layers(at, [&](std::size_t layer, float share) CCDT_INLINE {
            float* const first = nodes.data() + first_node(at, layer);
            for_taps(x, y, factor * share,
                     [&](std::size_t j, std::size_t i, float each) { first[j * x_.nodes + i] += each; });
        });
    }

    /// Column, row and layer of a node.
    using Node = std::array<std::size_t, 3>;

    std::size_t index(Node at) const { return (at[2] * y_.nodes + at[1]) * x_.nodes + at[0]; }

    /// Returns the first of the nodes that are identical to a node.
    Node first_of(Node at) const { return {at[0] % x_.period, at[1] % y_.period, at[2] % z_.period}; }

    /// Subtracts from a node and from all nodes identical to it.
    void lower(Node node, float weight) {
        const auto [column, row, layer] = first_of(node);
        for (std::size_t z = layer; z < z_.nodes; z += z_.period) {
            for (std::size_t y = row; y < y_.nodes; y += y_.period) {
                for (std::size_t x = column; x < x_.nodes; x += x_.period) actual_[index({x, y, z})] -= weight;
            }
        }
    }

    template <class Visit>
    void for_nodes(Visit&& visit) const {
        for (std::size_t z = 0; z < z_.nodes; ++z) {
            for (std::size_t y = 0; y < y_.nodes; ++y) {
                for (std::size_t x = 0; x < x_.nodes; ++x) visit(index({x, y, z}), index(first_of({x, y, z})));
            }
        }
    }

    /// Sums identical nodes and stores the sum in each.
    void join(std::vector<float>& nodes) const {
        for_nodes([&](std::size_t node, std::size_t first) {
            if (node != first) nodes[first] += nodes[node];
        });
        for_nodes([&](std::size_t node, std::size_t first) { nodes[node] = nodes[first]; });
    }

    bool is_torus_;
    float factor_;
    Axis x_, y_, z_;
    std::vector<float> wanted_;   ///< [nodes] smoothed number of wanted points, divided by the number of all points
    std::vector<float> actual_;   ///< [nodes] smoothed number of actual points
    std::vector<Around> around_;  ///< nodes around each point
};

}  // namespace ccdt::ordering
