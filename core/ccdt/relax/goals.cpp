// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/relax/goals.h"

#include <algorithm>
#include <utility>

#include "core/ccdt/relax/border_goals.h"

namespace ccdt {

namespace {

constexpr std::size_t kRange = 8192;  ///< triangles per task

/// Returns the factor that converts capacities to units of half a site's capacity.
double unit_of(const Triangulation& mesh, double total) {
    return 2 * static_cast<double>(mesh.site_count()) / total;
}

/// Whether few triangles have goals of their own, so that a hash table can store these goals. With more such triangles,
/// look-ups would dominate the time of a pass.
bool are_rare(const BorderGoals& border_goals, std::size_t triangles) {
    constexpr std::size_t kRims = 32;
    return border_goals.triangles.size() * kRims < triangles;
}

/// Computes the weights of triangles from their capacities.
class Weights {
public:
    Weights(const Triangulation& mesh, double total, double densest, const std::vector<double>& capacities)
        : mesh_(mesh), capacities_(capacities), unit_(unit_of(mesh, total)), largest_(unit_ * densest) {}

    double reached_by(std::uint32_t t) const { return unit_ * std::max(0.0, capacities_[t]); }
    double operator()(std::uint32_t t) const {
        const double area = mesh_.doubled_area(t);
        return area > 0 ? std::min(reached_by(t) / area, largest_) : largest_;
    }

    BorderGoals border_goals(std::span<const std::uint8_t> in_row = {}) const {
        return find_border_goals(
            mesh_, [this](std::uint32_t t) { return reached_by(t); }, *this, in_row);
    }

private:
    const Triangulation& mesh_;
    const std::vector<double>& capacities_;
    double unit_;
    double largest_;
};

/// Sets a goal for each triangle. A triangle that is not listed in `border_goals` gets its weight, and the target and
/// share 1.
template <class WeightOf>
void set_each(const Triangulation& mesh, const BorderGoals& border_goals, WeightOf&& weight_of,
              std::vector<TriangleGoal>& goals) {
    goals.resize(mesh.triangle_count());
    for_ranges(mesh.executor(), goals.size(), kRange, [&](std::size_t begin, std::size_t end) {
        for (auto t = static_cast<std::uint32_t>(begin); t < end; ++t) goals[t] = {weight_of(t), 1, 1};
    });
    for (std::size_t i = 0; i < border_goals.goals.size(); ++i)
        goals[border_goals.triangles[i]] = border_goals.goals[i];
}

}  // namespace

double set_goals(const Triangulation& mesh, const CapacityIntegral& capacity, const std::vector<double>& capacities,
                 std::vector<TriangleGoal>& goals) {
    return set_goals(mesh, capacity.total(), capacity.densest(), capacities, goals);
}

double set_goals(const Triangulation& mesh, double total, double densest, const std::vector<double>& capacities,
                 std::vector<TriangleGoal>& goals) {
    const Weights weights(mesh, total, densest, capacities);
    const BorderGoals border_goals = weights.border_goals();
    set_each(mesh, border_goals, weights, goals);
    return border_goals.reached.variation();
}

double set_goals(const Triangulation& mesh, double total, double densest, std::vector<double> capacities,
                 TriangleGoals& goals, std::span<const std::uint8_t> in_row) {
    const Weights weights(mesh, total, densest, capacities);
    BorderGoals border_goals = weights.border_goals(in_row);
    if (!are_rare(border_goals, mesh.triangle_count())) {
        std::vector<TriangleGoal> each = goals.release();
        set_each(mesh, border_goals, weights, each);
        goals = std::move(each);
        return border_goals.reached.variation();
    }
    for_ranges(mesh.executor(), capacities.size(), kRange, [&](std::size_t begin, std::size_t end) {
        for (auto t = static_cast<std::uint32_t>(begin); t < end; ++t) capacities[t] = weights(t);
    });
    goals = {std::move(capacities), std::move(border_goals.triangles), std::move(border_goals.goals)};
    return border_goals.reached.variation();
}

double set_even_goals(const Triangulation& mesh, double total, TriangleGoals& goals,
                      std::span<const std::uint8_t> in_row) {
    const double weight = unit_of(mesh, total) / 2;
    const auto weight_of = [&](std::uint32_t) { return weight; };
    const auto reached_by = [&](std::uint32_t t) { return weight * std::max(0.0, mesh.doubled_area(t)); };
    BorderGoals border_goals = find_border_goals(mesh, reached_by, weight_of, in_row);
    if (are_rare(border_goals, mesh.triangle_count())) {
        goals = {TriangleGoal{weight, 1, 1}, std::move(border_goals.triangles), std::move(border_goals.goals)};
    } else {
        std::vector<TriangleGoal> each;
        set_each(mesh, border_goals, weight_of, each);
        goals = std::move(each);
    }
    return border_goals.reached.variation();
}

}  // namespace ccdt
