// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/density/pieces_walk.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/geometry/point.h"

namespace ccdt {
namespace {

constexpr int kColumns = 40, kRows = 30;
constexpr double kRounding = 1e-12;

struct Piece {
    double column, row, from, to;

    bool operator==(const Piece&) const = default;
};

struct Segment {
    Point a, b;
};

/// Returns the pieces of two segments processed together, without those of length 0.
std::array<std::vector<Piece>, 2> pieces_of(const std::array<Segment, 2>& two) {
    const Segments<OneLane> segments{
        {two[0].a.x, two[1].a.x}, {two[0].a.y, two[1].a.y}, {two[0].b.x, two[1].b.x}, {two[0].b.y, two[1].b.y}};
    std::array<std::vector<Piece>, 2> pieces;
    walk_pieces(segments, kColumns, kRows, [&](Pair column, Pair row, Pair from, Pair to) {
        for (std::size_t i = 0; i < 2; ++i) {
            if (to[i] > from[i]) pieces[i].push_back({column[i], row[i], from[i], to[i]});
        }
    });
    return pieces;
}

void expect_covered(const Segment& segment, const std::vector<Piece>& pieces) {
    SCOPED_TRACE(testing::Message() << segment.a.x << ' ' << segment.a.y << " to " << segment.b.x << ' '
                                    << segment.b.y);
    double end = 0;
    for (const Piece& piece : pieces) {
        EXPECT_EQ(piece.from, end);
        end = piece.to;
        for (const double t : {piece.from, piece.to}) {
            const Point p = segment.a + t * (segment.b - segment.a);
            EXPECT_GE(p.x, piece.column - kColumns * kRounding);
            EXPECT_LE(p.x, piece.column + 1 + kColumns * kRounding);
            EXPECT_GE(p.y, piece.row - kRows * kRounding);
            EXPECT_LE(p.y, piece.row + 1 + kRows * kRounding);
        }
        EXPECT_TRUE(piece.column >= 0 && piece.column < kColumns && piece.row >= 0 && piece.row < kRows);
    }
    EXPECT_EQ(end, 1);
}

TEST(PiecesWalk, CoversSegmentsCellByCell) {
    Random random(1, 0);
    const auto position = [&] { return Point{kColumns * random.uniform(), kRows * random.uniform()}; };
    std::vector<Segment> segments;
    for (int i = 0; i < 1000; ++i) {
        const Point a = position(), near = a + std::pow(0.1, 10 * random.uniform()) * (position() - a);
        segments.push_back({a, i % 2 == 0 ? near : position()});
    }
    for (std::size_t i = 0; i < segments.size(); i += 2) {
        const std::array two{segments[i], segments[i + 1]};
        const auto pieces = pieces_of(two);
        for (std::size_t k = 0; k < 2; ++k) {
            expect_covered(two[k], pieces[k]);
            EXPECT_EQ(pieces[k], pieces_of({two[k], two[k]})[0]) << "whatever lies beside it";
        }
    }
}

/// Segments along grid lines, through grid points, of length 0, too thin to invert, and outside the grid by rounding.
TEST(PiecesWalk, CoversDegenerateSegments) {
    constexpr double kMin = std::numeric_limits<double>::denorm_min(), kTiny = 1e-308, kOff = 1e-15;
    const std::vector<double> xs{
        0, kMin, kTiny, -kTiny, -kOff, 7, 7 + kOff, 7.5, kColumns - kOff, kColumns, kColumns * (1 + kOff)};
    const std::vector<double> ys{
        0, kMin, kTiny, -kTiny, -kOff, 5, 5 - kOff, 5.5, kRows - kOff, kRows, kRows * (1 + kOff)};
    for (const double ax : xs) {
        for (const double bx : xs) {
            for (const double ay : ys) {
                for (const double by : ys) {
                    const Segment segment{{ax, ay}, {bx, by}};
                    expect_covered(segment, pieces_of({segment, {{1, 1}, {1, 1}}})[0]);
                }
            }
        }
    }
}

}  // namespace
}  // namespace ccdt
