// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/baselines/site_tree.h"

#include <algorithm>
#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace ccdt {
namespace {

struct Setting {
    std::string name;
    PeriodicImages images;
    Point sides;
};

std::vector<Setting> settings() {
    return {{"plane", PeriodicImages(Domain::rectangle(1, 0.5).value()), {1, 0.5}},
            {"torus", PeriodicImages(Domain::torus(1, 0.5).value()), {1, 0.5}},
            {"thin torus", PeriodicImages(Domain::torus(0.125, 1).value()), {0.125, 1}}};
}

/// Returns random sites, half of them crowded into a corner.
std::vector<Point> sites_in(Point sides, std::size_t count) {
    Random random(3, count);
    std::vector<Point> sites;
    for (std::size_t i = 0; i < count; ++i) {
        const double size = i % 2 == 0 ? 1 : 1e-3;
        const double x = size * random.uniform();
        sites.push_back({x * sides.x, size * random.uniform() * sides.y});
    }
    return sites;
}

double distance(const PeriodicImages& images, Point a, Point b) {
    const Point way = images.shortest(a - b);
    return std::sqrt(dot(way, way));
}

TEST(SiteTree, FindsTheNearestSiteNotHidden) {
    for (const auto& [name, images, sides] : settings()) {
        for (const std::size_t count : {1, 2, 7, 100}) {
            const auto sites = sites_in(sides, count);
            SiteTree tree(sites, images);
            std::set<std::uint32_t> remaining;
            for (std::uint32_t i = 0; i < count; ++i) remaining.insert(i);
            Random random(1, 0);
            while (!remaining.empty()) {
                const double x = random.uniform() * sides.x;
                const Point position{x, random.uniform() * sides.y};
                const auto found = tree.nearest(position);
                ASSERT_TRUE(found) << name;
                EXPECT_TRUE(remaining.contains(found->site)) << name;
                double least = 2;
                for (const std::uint32_t i : remaining) least = std::min(least, distance(images, sites[i], position));
                const Point way = found->position - position;
                EXPECT_NEAR(std::sqrt(dot(way, way)), least, 1e-15) << name;
                EXPECT_NEAR(distance(images, sites[found->site], found->position), 0, 1e-15) << name;
                remaining.erase(found->site);
                tree.hide(found->site);
            }
            EXPECT_FALSE(tree.nearest({0, 0})) << name;
        }
    }
}

TEST(SiteTree, FindsAllSitesWithinADistance) {
    for (const auto& [name, images, sides] : settings()) {
        const auto sites = sites_in(sides, 200);
        SiteTree tree(sites, images);
        tree.hide(5);
        Random random(2, 0);
        std::vector<SiteTree::Found> found;
        for (int i = 0; i < 100; ++i) {
            const double x = random.uniform() * sides.x;
            const Point position{x, random.uniform() * sides.y};
            const double reach = 0.3 * random.uniform();
            tree.within(position, reach, found);
            std::set<std::uint32_t> sites_found, expected;
            for (const auto& [site, copy] : found) {
                const Point way = copy - position;
                EXPECT_LE(dot(way, way), reach * reach) << name;
                EXPECT_NEAR(distance(images, sites[site], copy), 0, 1e-15) << name;
                sites_found.insert(site);
            }
            for (std::uint32_t s = 0; s < sites.size(); ++s) {
                if (distance(images, sites[s], position) < reach) expected.insert(s);
            }
            EXPECT_EQ(sites_found, expected) << name;
        }
    }
}

TEST(SiteTree, FindsSitesAcrossTheSeam) {
    const PeriodicImages images(Domain::torus(1, 1).value());
    const std::vector<Point> sites{{-0.1, 1.2}, {0.4, 0.6}};
    EXPECT_EQ(SiteTree(sites, images).nearest({0.9, 0.2})->site, 0u);
}

}  // namespace
}  // namespace ccdt
