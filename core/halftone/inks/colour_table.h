// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstddef>
#include <functional>
#include <mutex>
#include <utility>
#include <vector>

#include "core/halftone/inks/overprint.h"
#include "core/picture/tone.h"

namespace ccdt {

/// Quantity in which a ColourTable is linear between its nodes.
enum class Steps { Lightness, Light };

/// Approximates a function of colours by interpolation in a table. Evaluates the function at a node on first use.
///
/// Along each axis, nodes have equal steps of lightness, so they are dense in dark colours. Each cell of the table is
/// divided into six tetrahedra that share the cell's grey diagonal. The interpolation is linear in each tetrahedron.
/// The smallest of the three channels is linear there, too. The amount of black ink depends on it. Thread-safe.
///
/// @tparam Node  an array of float
template <class Node>
class ColourTable {
public:
    using Function = std::function<Node(const Light&)>;

    /// @param used  number of entries of a node that are interpolated; the remaining ones are 0
    ColourTable(Function function, Steps steps, std::size_t used = Node().size())
        : function_(std::move(function)), steps_(steps), used_(used), nodes_(kNodes * used), is_filled_(kNodes) {
        for (std::size_t i = 0; i < positions_.size(); ++i)
            positions_[i] = (kSide - 1) * lightness(std::min(1.0f, static_cast<float>(i) / kSteps));
        for (std::size_t i = 0; i < kSide; ++i) light_[i] = luminance(static_cast<float>(i) / (kSide - 1));
    }

    /// @param light  in [0, 1]
    Node operator()(const Light& light) {
        Node mixture{};
        for_corners(light, [&](std::size_t node, float weight) {
            const float* corner = at_node(node);
            for (std::size_t i = 0; i < used_; ++i) mixture[i] += weight * corner[i];
        });
        return mixture;
    }

    /// Returns the colours of the nodes that the interpolation at any of `lights` uses, each once.
    /// @param lights  in [0, 1]
    std::vector<Light> nodes_of(const std::vector<Light>& lights) const {
        std::vector<bool> is_used(kNodes);
        for (const Light& light : lights) for_corners(light, [&](std::size_t node, float) { is_used[node] = true; });
        std::vector<Light> colours;
        for (std::size_t node = 0; node < kNodes; ++node) {
            if (is_used[node]) colours.push_back(colour_of(node));
        }
        return colours;
    }

private:
    static constexpr std::size_t kSide = 17, kNodes = kSide * kSide * kSide;
    static constexpr std::size_t kSteps = 4096;  // steps of light in [0, 1]; lightness is linear between steps, to 1e-5

    /// Returns the position of a light on an axis, in nodes.
    float position_of(float light) const {
        const float step = light * kSteps;
        const auto below = static_cast<std::size_t>(step);
        return std::lerp(positions_[below], positions_[below + 1], step - static_cast<float>(below));
    }

    Light colour_of(std::size_t node) const {
        return {light_[node % kSide], light_[node / kSide % kSide], light_[node / (kSide * kSide)]};
    }

    /// Calls visit(node, weight) for the nodes between which a colour is interpolated. Weights are > 0.
    template <class Visit>
    void for_corners(const Light& light, const Visit& visit) const {
        struct Axis {
            float part;
            std::size_t step;
        };
        std::size_t node = 0;
        const auto axis = [&](float value, std::size_t step) {
            const float position = position_of(value);
            const std::size_t below = std::min(static_cast<std::size_t>(position), kSide - 2);
            node += below * step;
            const float part = steps_ == Steps::Lightness
                                   ? position - static_cast<float>(below)
                                   : (value - light_[below]) / (light_[below + 1] - light_[below]);
            return Axis{part, step};
        };
        std::array<Axis, 3> axes{axis(light.red, 1), axis(light.green, kSide), axis(light.blue, kSide * kSide)};
        const auto order = [&](Axis& a, Axis& b) {
            if (a.part < b.part) std::swap(a, b);
        };
        order(axes[0], axes[1]);
        order(axes[1], axes[2]);
        order(axes[0], axes[1]);
        const auto add = [&](float weight) {
            if (weight > 0) visit(node, weight);
        };
        add(1 - axes[0].part);
        for (std::size_t k = 0; k < 3; ++k) {
            node += axes[k].step;
            add(axes[k].part - (k < 2 ? axes[k + 1].part : 0));
        }
    }

    const float* at_node(std::size_t node) {
        if (!is_filled_[node].load(std::memory_order_acquire)) fill(node);
        return nodes_.data() + node * used_;
    }

    /// Computes a node, only once. Other threads that need the node wait.
    void fill(std::size_t node) {
        const std::lock_guard lock(filling_[node % filling_.size()]);
        if (is_filled_[node].load(std::memory_order_relaxed)) return;
        const Node values = function_(colour_of(node));
        std::copy_n(values.begin(), used_, nodes_.begin() + static_cast<std::ptrdiff_t>(node * used_));
        is_filled_[node].store(true, std::memory_order_release);
    }

    const Function function_;
    const Steps steps_;
    const std::size_t used_;
    std::array<float, kSteps + 2> positions_{};  ///< positions on an axis, in nodes, for equal steps of light from 0
    std::array<float, kSide> light_{};           ///< light at the nodes of an axis
    std::vector<float> nodes_;                   ///< [nodes][used]; red varies fastest
    std::vector<std::atomic<bool>> is_filled_;
    std::array<std::mutex, 64> filling_;  ///< each guards some of the nodes
};

}  // namespace ccdt
