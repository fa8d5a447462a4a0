// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/inks/print_proof.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include <gtest/gtest.h>

#include "core/ccdt/plane/ccdt.h"
#include "core/halftone/dots/dots.h"
#include "core/halftone/inks/separation.h"
#include "core/picture/blur.h"
#include "tests/support/inks.h"

namespace ccdt {
namespace {

constexpr int kSide = 60;

LightPlanes flat(float red, float green, float blue, int side = kSide) {
    const auto pixels = static_cast<std::size_t>(side) * static_cast<std::size_t>(side);
    return {std::vector<float>(pixels, red), std::vector<float>(pixels, green), std::vector<float>(pixels, blue)};
}

/// Returns a cyan dot and a black dot that overlap.
std::vector<std::vector<Point>> pair_of_dots() {
    return {{{30, 30}}, {}, {}, {{33, 30}}};
}

PrintProof proof_of(const LightPlanes& light, double radius = 4) {
    return PrintProof(light, {kSide, kSide}, kSide, kSide, test::cmyk_inks(), radius, 200);
}

TEST(PrintProof, MovesDotsApartWherePrintIsTooLight) {
    const auto moves = proof_of(flat(0.3f, 0.5f, 0.5f)).moves(pair_of_dots());
    EXPECT_LT(moves[0][0].x, -0.01);
    EXPECT_GT(moves[3][0].x, 0.01);
    EXPECT_NEAR(moves[0][0].y, 0, 0.02);
}

TEST(PrintProof, MovesDotsTogetherWherePrintIsTooDark) {
    const auto moves = proof_of(flat(1, 1, 1)).moves(pair_of_dots());
    EXPECT_GT(moves[0][0].x, 0.001);
    EXPECT_LT(moves[3][0].x, -0.001);
}

TEST(PrintProof, AcceptsCoarseGridOfLight) {
    const PrintProof coarse(flat(0.3f, 0.5f, 0.5f, 20), {20, 20}, kSide, kSide, test::cmyk_inks(), 4, 200);
    EXPECT_EQ(coarse.moves(pair_of_dots()), proof_of(flat(0.3f, 0.5f, 0.5f)).moves(pair_of_dots()));
}

TEST(PrintProof, LeavesIsolatedDots) {
    const auto moves =
        proof_of(flat(0.3f, 0.3f, 0.3f)).moves(std::vector<std::vector<Point>>{{{15, 15}}, {}, {}, {{40, 40}}});
    for (const auto& ink : moves) {
        for (const Point& move : ink) EXPECT_LT(std::hypot(move.x, move.y), 1e-9);
    }
}

TEST(PrintProof, LimitsLengthOfMoves) {
    const auto moves = proof_of(flat(0, 0, 0)).moves(pair_of_dots());
    for (const auto& ink : moves) {
        for (const Point& move : ink) EXPECT_LE(std::hypot(move.x, move.y), 0.15 * 4 + 1e-9);
    }
}

TEST(PrintProof, LeavesSparseDots) {
    EXPECT_EQ(proof_of(flat(0.3f, 0.5f, 0.5f), 0.4).moves(pair_of_dots())[0][0], Point{});
}

TEST(PrintProof, StopsOnRequest) {
    std::stop_source source;
    source.request_stop();
    const auto moves = proof_of(flat(0.3f, 0.5f, 0.5f)).moves(pair_of_dots(), source.get_token());
    EXPECT_EQ(moves[0][0], Point{});
    EXPECT_EQ(moves[3].size(), 1u);
}

/// Returns the mean squared error of the green light of a flat tint, blurred over three radii.
double blotches(const std::vector<Distribution>& runs, const InkSet& inks, const Light& wanted, int side,
                double radius) {
    constexpr int kScale = 3;
    const Canvas canvas{kScale * side, kScale * side, kScale};
    std::vector<Raster> rasters;
    for (const Distribution& run : runs)
        rasters.push_back(draw_dots(run.points, canvas, {kScale * radius, 0, false, 1}));
    std::vector<float> green;
    for (std::size_t p = 0; p < rasters[0].coverage.size(); ++p) {
        std::vector<float> here;
        for (const Raster& raster : rasters) here.push_back(raster.coverage[p] > 0 ? 1 : 0);
        green.push_back(printed(inks, here).green - wanted.green);
    }
    double sum = 0;
    for (const float off : blurred(green, canvas.width, canvas.height, 3 * kScale * radius))
        sum += static_cast<double>(off) * static_cast<double>(off);
    return sum / static_cast<double>(green.size());
}

TEST(PrintProof, ReducesBlotchesOfTint) {
    constexpr int kTint = 120;
    constexpr std::size_t kSites = 3000;
    const InkSet inks = test::cmyk_inks();
    const Light tint{0.3f, 0.13f, 0.08f};
    const ColourPicture pixel{1, 1, {tint.red}, {tint.green}, {tint.blue}, {}};
    const CoverageCurve curve;
    std::vector<double> areas;
    for (const auto& cover : separate(pixel, inks, Tone::Linear).coverage)
        areas.push_back(curve.dots(static_cast<double>(cover[0])));
    const double all = std::accumulate(areas.begin(), areas.end(), 0.0);
    const double radius = kTint * std::sqrt(all / (3.14159265 * kSites));
    const auto counts = share_sites(areas, kSites);
    const PrintProof proof(flat(tint.red, tint.green, tint.blue, kTint), {kTint, kTint}, kTint, kTint, inks, radius,
                           kSites);
    const Domain domain = Domain::rectangle(kTint, kTint).value();
    const std::vector<Density> densities(inks.inks.size(), Density::uniform());
    const auto plain = distribute_inks(domain, densities, counts, {.seed = 7}).value();
    const auto retouched =
        distribute_inks(domain, densities, counts, {.seed = 7}, {}, [&](std::span<const std::vector<Point>> sites) {
            return proof.moves(sites);
        }).value();
    EXPECT_LT(blotches(retouched, inks, tint, kTint, radius), 0.6 * blotches(plain, inks, tint, kTint, radius));
}

}  // namespace
}  // namespace ccdt
