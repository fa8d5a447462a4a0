#pragma once

#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "core/mesh/triangulation.h"

namespace ccdt {

/// Weight of a triangle's doubled area, and the target of their product. In units of half the capacity that one site
/// stands for, so that a triangle between three sites aims at 1.
struct TriangleGoal {
    double weight = 0;  ///< capacity per doubled area, held fixed while vertices move
    double target = 1;
    double share = 1;  ///< of a triangle of common size that it is, > 0: less than 1 for one of many in a narrow fan
};

/// The goals of all triangles: one for each; or, where most are to have a whole site's half, the weights of all and the
/// others' goals; or, where most are the same, that one and the others.
class TriangleGoals {
public:
    TriangleGoals() = default;

    /// @param all  [triangles]
    TriangleGoals(std::vector<TriangleGoal> all) : all_(std::move(all)) {}

    /// @param triangles  those that have goals of their own
    /// @param goals      [as many]
    TriangleGoals(const TriangleGoal& common, std::vector<std::uint32_t> triangles, std::vector<TriangleGoal> goals)
        : common_(common), triangles_(std::move(triangles)), own_(std::move(goals)) {
        list_slots();
    }

    /// @param weights           [triangles] >= 0; targets and shares are 1
    /// @param triangles, goals  as above
    TriangleGoals(std::vector<double> weights, std::vector<std::uint32_t> triangles, std::vector<TriangleGoal> goals)
        : weights_(std::move(weights)), triangles_(std::move(triangles)), own_(std::move(goals)) {
        for (const std::uint32_t triangle : triangles_) weights_[triangle] = -weights_[triangle];
        list_slots();
    }

    /// Goal of a triangle; of kNone, one that adds nothing.
    TriangleGoal of(std::uint32_t triangle) const {
        if (triangle < weights_.size() && !std::signbit(weights_[triangle])) return {weights_[triangle], 1, 1};
        return triangle < all_.size() ? all_[triangle] : rare(triangle);
    }

    /// Gives the room of one goal for each away.
    std::vector<TriangleGoal> release() { return std::exchange(all_, {}); }

    /// Gives the room of the weights away.
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

    /// Slot of a triangle, or the first empty one after those where it could be.
    std::size_t slot_of(std::uint32_t triangle) const {
        const std::size_t mask = slots_.size() - 1;
        std::size_t slot = (triangle * 0x9e3779b97f4a7c15 >> 32) & mask;
        while (slots_[slot] != Triangulation::kNone && triangles_[slots_[slot]] != triangle) slot = (slot + 1) & mask;
        return slot;
    }

    std::vector<TriangleGoal> all_;
    std::vector<double> weights_;  ///< [triangles], negative or -0 of those that have goals of their own
    TriangleGoal common_;
    std::vector<std::uint32_t> triangles_;
    std::vector<TriangleGoal> own_;     ///< [those triangles]
    std::vector<std::uint32_t> slots_;  ///< by triangles' hashes: their number among those, or kNone
};

}  // namespace ccdt
