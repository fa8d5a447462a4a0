// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/polish/graph_solver.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/base/thread_executor.h"

namespace ccdt {
namespace {

using Edge = GraphSolver::Edge;

/// Returns the edges of a square grid, with conductance 1.
std::vector<Edge> grid(std::uint32_t side) {
    std::vector<Edge> edges;
    for (std::uint32_t j = 0; j < side; ++j) {
        for (std::uint32_t i = 0; i < side; ++i) {
            if (i + 1 < side) edges.push_back({j * side + i, j * side + i + 1, 1});
            if (j + 1 < side) edges.push_back({j * side + i, (j + 1) * side + i, 1});
        }
    }
    return edges;
}

double squares(const std::vector<double>& values) {
    double sum = 0;
    for (const double value : values) sum += value * value;
    return sum;
}

TEST(GraphSolver, SolvesAChain) {
    constexpr std::size_t kCount = 50;
    std::vector<Edge> chain;
    for (std::uint32_t v = 0; v + 1 < kCount; ++v) chain.push_back({v, v + 1, 2});
    GraphSolver solver(kCount, chain);
    std::vector<double> inflow(kCount, 0), potential(kCount);
    inflow.front() = 1;
    inflow.back() = -1;
    solver.solve(inflow, potential, 60);
    for (std::size_t v = 0; v + 1 < kCount; ++v) EXPECT_NEAR(potential[v] - potential[v + 1], 0.5, 1e-9) << v;
}

TEST(GraphSolver, AddsUpParallelEdges) {
    GraphSolver solver(2, std::vector<Edge>{{0, 1, 1}, {1, 0, 3}});
    ASSERT_EQ(solver.links(0).size(), 1u);
    std::vector<double> inflow{1, -1}, potential(2);
    solver.solve(inflow, potential, 3);
    EXPECT_NEAR(potential[0] - potential[1], 0.25, 1e-12);
}

/// 16 times as many vertices need about the same number of steps.
TEST(GraphSolver, ConvergesInFewStepsAtAnySize) {
    for (const std::uint32_t side : {32u, 128u}) {
        std::vector<double> inflow, potential(side * side);
        double mean = 0;
        for (std::uint32_t v = 0; v < side * side; ++v) mean += inflow.emplace_back(Random(7, v).uniform());
        for (double& value : inflow) value -= mean / (side * side);
        GraphSolver solver(side * side, grid(side));
        const double before = squares(inflow);
        solver.solve(inflow, potential, 8);
        EXPECT_LT(squares(inflow), 1e-4 * before) << side;
    }
}

TEST(GraphSolver, IsIdenticalOnAnyNumberOfThreads) {
    constexpr std::uint32_t kSide = 128;
    std::vector<double> inflow;
    for (std::uint32_t v = 0; v < kSide * kSide; ++v) inflow.push_back(v % 2 == 0 ? 1 : -1);
    std::ranges::shuffle(inflow, std::minstd_rand(1));
    const auto solved_by = [&](Executor& executor) {
        GraphSolver solver(kSide * kSide, grid(kSide), executor);
        std::vector<double> remaining = inflow, potential(kSide * kSide);
        solver.solve(remaining, potential, 3);
        return potential;
    };
    const auto expected = solved_by(inline_executor());
    for (const std::size_t size : {2, 3, 16}) {
        ThreadExecutor executor(size);
        EXPECT_EQ(solved_by(executor), expected) << size << " threads";
    }
}

TEST(GraphSolver, SolvesEachComponentSeparately) {
    auto edges = grid(8);
    for (const Edge& edge : grid(5)) edges.push_back({edge.a + 64, edge.b + 64, edge.conductance});
    GraphSolver solver(64 + 25 + 1, edges);
    std::vector<double> inflow(90, 0), potential(90, 7);
    inflow[64] = 1;
    inflow[88] = -1;
    solver.solve(inflow, potential, 30);
    EXPECT_LT(squares(inflow), 1e-18);
    for (std::size_t v = 0; v < 64; ++v) EXPECT_EQ(potential[v], 0) << v;
    EXPECT_EQ(potential[89], 0) << "no edge";
}

}  // namespace
}  // namespace ccdt
