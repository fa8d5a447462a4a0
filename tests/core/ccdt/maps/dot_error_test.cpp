// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/maps/dot_error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "tests/support/shapes.h"

namespace ccdt {
namespace {

using test::box;

/// Adjacent squares, with dots on a square grid in each.
class Squares {
public:
    /// @param rows  [squares] rows of dots in each square
    explicit Squares(const std::vector<int>& rows) {
        for (std::size_t i = 0; i < rows.size(); ++i) {
            const auto west = static_cast<double>(i);
            features_.push_back({Domain::repair({{box(west, 0, 1, 1), {}}}).value().domain,
                                 {static_cast<std::size_t>(rows[i]) * static_cast<std::size_t>(rows[i])}});
            for (int row = 0; row < rows[i]; ++row) {
                for (int column = 0; column < rows[i]; ++column)
                    dots_.push_back(
                        {{west + (column + 0.5) / rows[i], (row + 0.5) / rows[i]}, static_cast<std::uint32_t>(i)});
            }
        }
    }

    const std::vector<FeatureDot>& dots() const { return dots_; }

    /// @param positions  [dots]
    std::vector<double> errors(const std::vector<Point>& positions) const {
        std::vector<FeatureArea> areas;
        std::vector<const Domain*> domains;
        for (const MapFeature& feature : features_) {
            areas.emplace_back(feature.area);
            domains.push_back(&feature.area);
        }
        const FeatureIndex index(areas);
        const Domain land = Domain::united(domains).value();
        const Density density = Density::uniform();
        const auto ground =
            DotGround::create({features_, areas, index, land.bounds(), density}, 0, inline_executor(), {}).value();
        std::vector<Point> units;
        for (const Point& p : positions) units.push_back(land.to_unit(p));
        std::vector<double> errors(positions.size());
        DotError(ground, land, dots_).measure(units, errors);
        return errors;
    }

    std::vector<double> errors() const {
        std::vector<Point> positions;
        for (const FeatureDot& dot : dots_) positions.push_back(dot.position);
        return errors(positions);
    }

private:
    std::vector<MapFeature> features_;
    std::vector<FeatureDot> dots_;
};

TEST(DotError, FindsNoErrorInGrids) {
    const Squares squares({20, 20});
    const auto errors = squares.errors();
    for (std::size_t dot = 0; dot < errors.size(); ++dot) {
        const Point p = squares.dots()[dot].position;
        if (std::abs(p.x - 1) < 0.7 && std::abs(p.y - 0.5) < 0.3) {
            EXPECT_NEAR(errors[dot], 0, 1e-3) << p.x << ' ' << p.y;
        }
    }
}

TEST(DotError, LocatesASurplus) {
    const Squares squares({20, 20});
    std::vector<Point> positions;
    for (const FeatureDot& dot : squares.dots()) positions.push_back({dot.position.x, dot.position.y * dot.position.y});
    const auto errors = squares.errors(positions);
    for (std::size_t dot = 0; dot < errors.size(); ++dot) {
        if (positions[dot].y < 0.15) {
            EXPECT_GT(errors[dot], 0.05);
        }
        if (positions[dot].y > 0.4) {
            EXPECT_LT(errors[dot], -0.05);
        }
    }
}

/// Errors include the dots of neighbouring features whose spacings are in the same octave or in an adjacent one.
TEST(DotError, IncludesNeighbouringFeatures) {
    for (const int rows : {20, 28}) {
        const Squares squares({20, rows});
        std::vector<Point> positions;
        for (const FeatureDot& dot : squares.dots())
            positions.push_back(dot.feature == 0 ? dot.position
                                                 : Point{1 + std::pow(dot.position.x - 1, 2), dot.position.y});
        const auto errors = squares.errors(positions);
        for (std::size_t dot = 0; dot < errors.size(); ++dot) {
            const bool is_last = positions[dot].x < 1 && positions[dot].x > 0.97;
            if (is_last && std::abs(positions[dot].y - 0.5) < 0.3) {
                EXPECT_GT(errors[dot], 0.1) << rows;
            }
        }
    }
}

/// The neighbouring feature is almost empty, or so dense that its dots would outweigh all others.
TEST(DotError, IgnoresFeaturesOfVeryDifferentDensity) {
    for (const int rows : {200, 3}) {
        const Squares squares({20, rows});
        const auto errors = squares.errors();
        for (std::size_t dot = 0; dot < 400; ++dot) {
            const Point p = squares.dots()[dot].position;
            if (p.x > 0.2 && std::abs(p.y - 0.5) < 0.3) {
                EXPECT_NEAR(errors[dot], 0, 0.1) << rows;
            }
        }
    }
}

}  // namespace
}  // namespace ccdt
