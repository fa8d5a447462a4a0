// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/mesh/triangulation.h"

namespace ccdt {

/// The goal of a triangle. The triangle's capacity is weight * doubled area, and should be near the target. The unit of
/// capacities is half a site's capacity, so a triangle between three sites has the target 1.
struct TriangleGoal {
    double weight = 0;  ///< capacity per doubled area, held fixed while vertices move
    double target = 1;
    double share = 1;  ///< fraction of a whole triangle, in (0, 1]; below 1 where one site faces several border edges
};

/// The goals of all triangles, in one of three forms. The first form has a goal for each triangle. If most targets are
/// 1, the second form has a weight for each triangle, and whole goals for the few other triangles. The third form has a
/// common goal, and separate goals for a few triangles.
class TriangleGoals {
public:
    TriangleGoals() = default;

    /// @param all  [triangles]
    TriangleGoals(std::vector<TriangleGoal> all) : all_(std::move(all)) {}

    /// @param triangles  the triangles that have goals of their own
    /// @param goals      goals of these triangles [triangles.size()]
    TriangleGoals(const TriangleGoal& common, std::vector<std::uint32_t> triangles, std::vector<TriangleGoal> goals)
        : common_(common), triangles_(std::move(triangles)), own_(std::move(goals)) {
        list_slots();
    }

    /// @param weights           [all triangles] >= 0; targets and shares are 1
    /// @param triangles, goals  the triangles that have goals of their own, and these goals
    TriangleGoals(std::vector<double> weights, std::vector<std::uint32_t> triangles, std::vector<TriangleGoal> goals)
        : weights_(std::move(weights)), triangles_(std::move(triangles)), own_(std::move(goals)) {
        for (const std::uint32_t triangle : triangles_) weights_[triangle] = -weights_[triangle];
        list_slots();
    }

    /// Returns the goal of a triangle; for kNone, a goal without effect.
    TriangleGoal of(std::uint32_t triangle) const {
        if (triangle < weights_.size() && !std::signbit(weights_[triangle])) return {weights_[triangle], 1, 1};
        return triangle < all_.size() ? all_[triangle] : rare(triangle);
    }

    /// Returns the memory of the individual goals for reuse. The goals are lost.
    std::vector<TriangleGoal> release() { return std::exchange(all_, {}); }

    /// Returns the memory of the weights for reuse. The weights are lost.
    std::vector<double> release_weights() { return std::exchange(weights_, {}); }

private:
    TriangleGoal rare(std::uint32_t triangle) const {
        if (triangle == Triangulation::kNone) return {0, 0, 1};
        const std::uint32_t at = slots_.empty() ? Triangulation::kNone : slots_[slot_of(triangle)];
        return at == Triangulation::kNone ? common_ : own_[at];
    }

    void list_slots() {
        slots_.assign(std::bit_ceil(2 * triangles_.size()), Triangulation::kNone);
        for (std::uint32_t i = 0; i < triangles_.size(); ++i) slots_[slot_of(triangles_[i])] = i;
    }

    /// Returns the hash slot of a triangle, or the first empty slot of its probe sequence.
    std::size_t slot_of(std::uint32_t triangle) const {
        const std::size_t mask = slots_.size() - 1;
        std::size_t slot = (triangle * 0x9e3779b97f4a7c15 >> 32) & mask;
        while (slots_[slot] != Triangulation::kNone && triangles_[slots_[slot]] != triangle) slot = (slot + 1) & mask;
        return slot;
    }

    std::vector<TriangleGoal> all_;
    std::vector<double> weights_;  ///< [triangles] weights; negative or -0 for triangles that have goals of their own
    TriangleGoal common_;
    std::vector<std::uint32_t> triangles_;
    std::vector<TriangleGoal> own_;     ///< [triangles_] goals of these triangles
    std::vector<std::uint32_t> slots_;  ///< hash table: index into triangles_, or kNone
};

}  // namespace ccdt
