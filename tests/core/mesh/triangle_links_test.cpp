// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/mesh/triangle_links.h"

#include <gtest/gtest.h>

#include <numeric>
#include <set>
#include <utility>

#include "core/base/random.h"

namespace ccdt {
namespace {

using Links = TriangleLinks;
constexpr std::uint32_t kNone = Links::kNone;

/// Joins half-edges of the same two vertices, and stores an edge for each vertex.
void join_all(Links& links) {
    for (std::uint32_t h = 0; h < 4 * links.triangle_count(); ++h) {
        for (std::uint32_t k = 0; k < h && h % 4 != 3; ++k) {
            if (k % 4 != 3 && links.origin(h) == links.target(k) && links.target(h) == links.origin(k))
                links.join(h, k);
        }
    }
    for (std::uint32_t h = 0; h < 4 * links.triangle_count(); ++h) {
        if (h % 4 != 3) links.keep_edge(h);
    }
}

Links octahedron() {
    Links links;
    links.add_vertices(6);
    for (const std::uint32_t pole : {0U, 5U}) {
        for (std::uint32_t i = 0; i < 4; ++i) {
            const std::uint32_t a = 1 + i, b = 1 + (i + 1) % 4;
            links.add(pole == 0 ? std::array{pole, a, b} : std::array{pole, b, a});
        }
    }
    join_all(links);
    return links;
}

/// A strip of triangles with a border: two rows of vertices.
Links strip() {
    Links links;
    links.add_vertices(8);
    for (std::uint32_t i = 0; i < 3; ++i) {
        links.add({i, i + 1, i + 5});
        links.add({i, i + 5, i + 4});
    }
    join_all(links);
    return links;
}

/// Checks twins and stored edges. Returns vertices - edges + triangles.
int euler_characteristic(const Links& links) {
    int triangles = 0, sides = 0, borders = 0;
    std::set<std::uint32_t> vertices;
    for (std::uint32_t t = 0; t < links.triangle_count(); ++t) {
        if (links.is_removed(t)) continue;
        ++triangles;
        for (std::uint32_t i = 0; i < 3; ++i) {
            const std::uint32_t h = Links::edge(t, i), twin = links.twin(h);
            ++sides;
            vertices.insert(links.origin(h));
            if (twin == kNone) {
                ++borders;
                EXPECT_EQ(links.edge_of(links.origin(h)), h);
                continue;
            }
            EXPECT_EQ(links.twin(twin), h);
            EXPECT_EQ(links.origin(twin), links.target(h));
            EXPECT_EQ(links.is_constrained(twin), links.is_constrained(h));
        }
    }
    for (const std::uint32_t v : vertices) {
        EXPECT_EQ(links.origin(links.edge_of(v)), v);
        int around = 0, all = 0;
        links.for_edges(v, [&](std::uint32_t) { ++around; });
        for (std::uint32_t t = 0; t < links.triangle_count(); ++t) {
            for (const std::uint32_t corner : links.corners(t)) all += corner == v;
        }
        EXPECT_EQ(around, all) << v;
    }
    return static_cast<int>(vertices.size()) - (sides + borders) / 2 + triangles;
}

TEST(TriangleLinks, KeepsTheTopologyOfAnOctahedron) {
    Links links = octahedron();
    EXPECT_EQ(euler_characteristic(links), 2);
    links.add_vertices(2);
    links.divide(6, 3);
    EXPECT_EQ(euler_characteristic(links), 2);
    const std::uint32_t edge = links.edge_of(5), end = links.target(edge), apex = links.apex(edge);
    const std::uint32_t after = links.split(7, edge);
    EXPECT_EQ(euler_characteristic(links), 2);
    EXPECT_EQ(links.target(edge), 7U);
    EXPECT_EQ(links.origin(after), end);
    EXPECT_EQ(links.target(after), apex);
    EXPECT_TRUE(links.are_joined(7, 5));
    links.flip(links.edge_of(7));
    EXPECT_EQ(euler_characteristic(links), 2);
}

TEST(TriangleLinks, CollapsesAnEdge) {
    Links links = octahedron();
    links.add_vertices(1);
    links.divide(6, 0);
    const std::size_t before = links.triangle_count();
    links.collapse(links.edge_of(6));
    EXPECT_EQ(links.edge_of(6), kNone);
    EXPECT_EQ(euler_characteristic(links), 2);
    links.divide(6, links.is_removed(0) ? 1 : 0);
    EXPECT_EQ(links.triangle_count(), before);  // the numbers of removed triangles are used again
    EXPECT_EQ(euler_characteristic(links), 2);
}

TEST(TriangleLinks, SplitsAndCollapsesEdgesOfABorder) {
    Links links = strip();
    EXPECT_EQ(euler_characteristic(links), 1);
    links.add_vertices(1);
    const std::uint32_t border = links.edge_of(1);
    links.set_constrained(border, true);
    links.split(8, border);
    EXPECT_EQ(euler_characteristic(links), 1);
    EXPECT_TRUE(links.is_constrained(border));
    EXPECT_TRUE(links.is_constrained(links.edge_of(8)));
    links.collapse(links.edge_of(8));
    EXPECT_EQ(euler_characteristic(links), 1);
}

TEST(TriangleLinks, NumbersRemainingTrianglesSuccessively) {
    Links links = octahedron();
    links.add_vertices(1);
    links.divide(6, 0);
    links.collapse(links.edge_of(6));
    std::vector<std::uint32_t> numbers(7);
    std::iota(numbers.begin(), numbers.end(), 0U);
    std::swap(numbers[0], numbers[5]);
    links.renumber(numbers, 6);
    EXPECT_EQ(links.triangle_count(), 8U);
    EXPECT_EQ(euler_characteristic(links), 2);
}

TEST(TriangleLinks, KeepsTheTopologyInRandomSequences) {
    for (std::uint64_t seed = 0; seed < 20; ++seed) {
        Links links = octahedron();
        Random random(seed, 0);
        const auto any = [&](std::size_t count) {
            return static_cast<std::uint32_t>(random.uniform() * static_cast<double>(count));
        };
        for (std::uint32_t v = 6; v < 60; ++v) {
            links.add_vertices(1);
            if (random.uniform() < 0.5) {
                links.divide(v, any(links.triangle_count()));
            } else {
                links.split(v, Links::edge(any(links.triangle_count()), any(3)));
            }
            const std::uint32_t h = Links::edge(any(links.triangle_count()), any(3));
            const std::uint32_t c = links.apex(h), d = links.apex(links.twin(h));
            if (c != d && !links.are_joined(c, d)) links.flip(h);
        }
        EXPECT_EQ(euler_characteristic(links), 2) << seed;
    }
}

}  // namespace
}  // namespace ccdt
