// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/globe/plane_density.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <utility>
#include <vector>

#include "core/ccdt/globe/chart.h"
#include "core/ccdt/globe/turns.h"
#include "core/ccdt/relax/capacity_integral.h"

namespace ccdt {

namespace {

/// A grid of the values of a function at the centres of cells, stretched over a box.
struct Raster {
    int columns = 0;
    int rows = 0;
    std::vector<double> values;
};

/// Returns the number of cells along the longer side of a part's box, from 16 to 1,024. The number is so large that the
/// scale of ground areas changes little between cells. But it is at most the larger of 256 and 8 sqrt(sites).
int cells_for_ground(const Box& box, std::size_t sites) {
    constexpr double kStep = 0.005, kPerSite = 8, kMin = 16, kFew = 256, kMax = 1'024;
    const double most = std::clamp(kPerSite * std::sqrt(static_cast<double>(sites)), kFew, kMax);
    const Point corner{std::max(std::abs(box.min.x), std::abs(box.max.x)),
                       std::max(std::abs(box.min.y), std::abs(box.max.y))};
    const double farthest = std::min(std::sqrt(dot(corner, corner)), 2.0);
    const double slope = farthest / (1 + farthest * farthest / 4);  // twice the slope of the scale's logarithm
    return static_cast<int>(std::clamp(std::max(box.width(), box.height()) * slope / kStep, kMin, most));
}

/// Reads a density at positions in degrees.
class Wanted {
public:
    Wanted(const Domain& degrees, const Density& density) : box_(degrees.bounds()), density_(density) {}

    double operator()(Point position) const {
        position.x += longitude_wrap_offset(position.x, box_.min.x);
        // A position outside the box belongs to the nearer one of its west and east sides.
        if (position.x - box_.max.x > (kTurn - box_.width()) / 2) position.x -= kTurn;
        const auto index = [](double share, int cells) {
            return std::clamp(static_cast<int>(std::clamp(share, 0.0, 1.0) * cells), 0, cells - 1);
        };
        return density_.value(index((position.x - box_.min.x) / box_.width(), density_.width()),
                              index((position.y - box_.min.y) / box_.height(), density_.height()));
    }

private:
    Box box_;
    const Density& density_;
};

Raster draw(const ChartedPart& part, const Domain& degrees, const Density& density, std::size_t sites,
            const std::stop_token& stop) {
    constexpr int kMax = 2'048;
    const Box& box = part.domain.bounds();
    int cells = cells_for_ground(box, sites);
    if (!density.is_uniform()) cells = std::clamp(2 * std::max(density.width(), density.height()), cells, kMax);
    const double cell = std::max(box.width(), box.height()) / cells;
    Raster raster{std::max(1, static_cast<int>(std::ceil(box.width() / cell))),
                  std::max(1, static_cast<int>(std::ceil(box.height() / cell))),
                  {}};
    const Wanted wanted(degrees, density);
    for (int row = 0; row < raster.rows && !stop.stop_requested(); ++row) {
        for (int column = 0; column < raster.columns; ++column) {
            const Point p{box.min.x + (column + 0.5) / raster.columns * box.width(),
                          box.min.y + (row + 0.5) / raster.rows * box.height()};
            double value = part.chart.ground(p);
            if (!density.is_uniform()) value *= wanted(position_of(part.chart.to_direction(p)));
            raster.values.push_back(value);
        }
    }
    return raster;
}

}  // namespace

Result<PlaneDensity> plane_density(const ChartedPart& part, const Domain& degrees, const Density& density,
                                   std::size_t sites, const std::stop_token& stop) {
    constexpr double kEven = 1.002;  // with less variation, an even density is accurate to a thousandth
    const Raster raster = draw(part, degrees, density, sites, stop);
    if (stop.stop_requested()) return failure(ErrorCode::Stopped, "stopped before the density was made");
    const auto [least, most] = std::ranges::minmax(raster.values);
    if (most <= kEven * least) return PlaneDensity{Density::uniform(), part.domain.area() * (least + most) / 2};
    auto made = Density::grid(raster.columns, raster.rows, std::span<const double>(raster.values));
    if (!made) return tl::unexpected(made.error());
    PlaneDensity result{density.is_uniform() ? (*std::move(made)).smooth() : *std::move(made), 0};
    const Box& box = part.domain.bounds();
    const double cell = box.width() / raster.columns * (box.height() / raster.rows);
    result.total = std::ldexp(CapacityIntegral(part.domain, result.density).total() * cell, std::ilogb(most));
    return result;
}

}  // namespace ccdt
