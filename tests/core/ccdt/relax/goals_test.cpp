// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/relax/goals.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

#include "tests/support/meshes.h"

namespace ccdt {
namespace {

using test::domain_of;
using test::StartMesh;

std::vector<std::pair<std::string, Domain>> domains() {
    const Ring outer{{0, 0}, {4, 0}, {4, 3}, {0, 3}}, hole{{1, 1}, {1, 2}, {3, 2}, {3, 1}};
    return {{"square", Domain::rectangle(1, 1).value()},
            {"torus", Domain::torus(1, 1).value()},
            {"ring", domain_of(test::Parts{{outer, {hole}}})}};
}

/// The goals of a uniform density equal those derived from the areas of triangles, stored individually or not.
TEST(EvenGoals, EqualTheGoalsOfEachTriangle) {
    for (const bool fixed : {false, true}) {
        for (auto& [name, domain] : domains()) {
            StartMesh start(std::move(domain), Density::uniform(), {.sites = 400, .seed = 5});
            if (fixed) start.mesh.fix_last(60);
            const double variation = start.measure();
            TriangleGoals goals;
            EXPECT_NEAR(set_even_goals(start.mesh, start.capacity.total(), goals), variation, 1e-9) << name;
            for (std::uint32_t t = 0; t < start.mesh.triangle_count(); ++t) {
                const TriangleGoal goal = goals.of(t), &expected = start.goals[t];
                ASSERT_NEAR(goal.weight / expected.weight, 1, 1e-9) << name;
                ASSERT_NEAR(goal.target, expected.target, 1e-9) << name;
                ASSERT_NEAR(goal.share, expected.share, 1e-9) << name;
            }
        }
    }
}

/// The test would take hours if each triangle summed all edges that its site faces.
TEST(Goals, SumTheEdgesThatASiteFacesOnce) {
    StartMesh start(domain_of({{test::circle({0, 0}, 1, 200'000), {}}}), Density::uniform(), {.sites = 2, .seed = 5});
    start.measure();
    EXPECT_EQ(start.goals.size(), start.mesh.triangle_count());
}

TEST(TriangleGoals, AreNeutralForNoTriangle) {
    const TriangleGoals each(std::vector<TriangleGoal>{{3, 1, 1}}), rare(TriangleGoal{2, 1, 1}, {4}, {{5, 0.5, 0.5}});
    const TriangleGoals weights(std::vector<double>{2, 0, 3}, {1}, {{5, 0.5, 0.5}});
    EXPECT_EQ(each.of(0).weight, 3);
    EXPECT_EQ(rare.of(3).weight, 2);
    EXPECT_EQ(rare.of(4).weight, 5);
    EXPECT_EQ(rare.of(5).weight, 2);
    EXPECT_EQ(weights.of(0).weight, 2);
    EXPECT_EQ(weights.of(0).share, 1);
    EXPECT_EQ(weights.of(1).weight, 5);
    EXPECT_EQ(weights.of(2).target, 1);
    for (const TriangleGoals& goals : {each, rare, weights}) {
        EXPECT_EQ(goals.of(Triangulation::kNone).weight, 0);
        EXPECT_EQ(goals.of(Triangulation::kNone).target, 0);
    }
}

}  // namespace
}  // namespace ccdt
