// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/baselines/equal_cells.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace ccdt {
namespace {

constexpr std::size_t kSites = 60;
constexpr std::size_t kCapacity = 32;

std::vector<Point> random_points(std::size_t count, std::uint64_t seed) {
    Random random(seed, 0);
    std::vector<Point> points;
    for (std::size_t i = 0; i < count; ++i) {
        const double x = random.uniform();
        points.push_back({x, 0.5 * random.uniform()});
    }
    return points;
}

struct Setting {
    std::string name;
    PeriodicImages images;
};

std::vector<Setting> settings() {
    return {{"plane", PeriodicImages(Domain::rectangle(1, 0.5).value())},
            {"torus", PeriodicImages(Domain::torus(1, 0.5).value())}};
}

EqualCells start(const PeriodicImages& images) {
    return EqualCells(random_points(kSites * kCapacity, 1), random_points(kSites, 101), images, {});
}

std::vector<Point> sorted(std::vector<Point> points) {
    std::ranges::sort(points, {}, [](Point p) { return std::pair(p.x, p.y); });
    return points;
}

std::vector<Point> all_samples(const EqualCells& cells) {
    std::vector<Point> all;
    for (std::size_t i = 0; i < kSites; ++i) all.insert(all.end(), cells.cell(i).begin(), cells.cell(i).end());
    return all;
}

double squared(const PeriodicImages& images, Point a, Point b) {
    const Point way = images.shortest(a - b);
    return dot(way, way);
}

/// Returns the gain of the best swap of two samples between two cells.
double best_gain(const EqualCells& cells, const PeriodicImages& images, std::size_t i, std::size_t j) {
    const auto most = [&](std::size_t own, std::size_t other) {
        double gain = -1;
        for (const Point& p : cells.cell(own)) {
            gain = std::max(gain,
                            squared(images, p, cells.centroids()[own]) - squared(images, p, cells.centroids()[other]));
        }
        return gain;
    };
    return most(i, j) + most(j, i);
}

TEST(EqualCells, AssignEqualNumbersOfSamples) {
    for (const auto& [name, images] : settings()) {
        EqualCells cells = start(images);
        const auto given = sorted(random_points(kSites * kCapacity, 1));
        EXPECT_EQ(sorted(all_samples(cells)), given) << name;
        for (int i = 0; i < 5; ++i) cells.sweep({});
        for (std::size_t i = 0; i < kSites; ++i) EXPECT_EQ(cells.cell(i).size(), kCapacity) << name;
        EXPECT_EQ(sorted(all_samples(cells)), given) << name;
    }
}

TEST(EqualCells, LowerTheEnergyUntilNoSwapIsLeft) {
    for (const auto& [name, images] : settings()) {
        EqualCells cells = start(images);
        const double first = cells.energy();
        int sweeps = 0;
        for (double before = first; cells.sweep({}); before = cells.energy(), ++sweeps) {
            EXPECT_LT(cells.energy(), before) << name;
            ASSERT_LT(sweeps, 200) << name;
        }
        EXPECT_GT(sweeps, 3) << name;
        EXPECT_LT(cells.energy(), 0.7 * first) << name;
        for (std::size_t i = 0; i < kSites; ++i) {
            for (std::size_t j = 0; j < i; ++j) EXPECT_LT(best_gain(cells, images, i, j), 1e-8) << name;
        }
        EXPECT_FALSE(cells.sweep({})) << name;
    }
}

TEST(EqualCells, HaveSitesAtTheCentroids) {
    for (const auto& [name, images] : settings()) {
        EqualCells cells = start(images);
        for (int sweep = 0; sweep < 4; ++sweep) {
            for (std::size_t i = 0; i < kSites; ++i) {
                Point sum;
                for (const Point& p : cells.cell(i)) sum = sum + images.shortest(p - cells.centroids()[i]);
                // On a torus the moving centroid can change which copy of a distant sample is nearest.
                const double limit = images.is_torus() && sweep == 0 ? 0.1 : 1e-12;
                EXPECT_LT(std::sqrt(dot(sum, sum)) / kCapacity, limit) << name << ", " << sweep;
            }
            cells.sweep({});
        }
    }
}

TEST(EqualCells, AcceptAnyNumberOfSamples) {
    for (const std::size_t capacity : {1, 2, 3, 7, 64}) {
        for (const std::size_t sites : {1, 2, 6}) {
            EqualCells cells(random_points(sites * capacity, 1), random_points(sites, 2), settings()[0].images, {});
            while (cells.sweep({})) continue;
            EXPECT_EQ(cells.cell(sites - 1).size(), capacity);
        }
    }
}

TEST(EqualCells, StopOnRequest) {
    std::stop_source stop;
    stop.request_stop();
    EqualCells cells = start(settings()[0].images);
    EXPECT_FALSE(cells.sweep(stop.get_token()));
}

}  // namespace
}  // namespace ccdt
