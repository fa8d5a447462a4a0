// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/points/analysis/polygon_taper.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <span>

#include "core/base/elementary.h"
#include "core/density/coverage.h"
#include "core/geometry/inset.h"

namespace ccdt {
namespace {

constexpr double kCellsPerDepth = 64;  // wanted number of cells in the largest depth
constexpr double kMinCellsPerDepth = 4;
constexpr int kMinSide = 16;

/// Returns the number of cells along a side of the box.
int cells_along(double side, double cell) {
    return good_size(std::max<double>(kMinSide, std::ceil(side / cell)));
}

/// Returns the wanted side of the cells in the unit frame.
double cell_of(const Domain& domain) {
    const Point sides = domain.unit_bounds().max;
    const double depth = largest_clearance(domain) / std::max(domain.bounds().width(), domain.bounds().height());
    return std::max(depth / kCellsPerDepth, std::sqrt(sides.x * sides.y / PolygonTaper::kMaxCells));
}

/// Replaces squared distances along a line of cells by min over j of (distances[j] + ((i - j) * step)^2), in linear
/// time. Source: Felzenszwalb, Huttenlocher, Distance Transforms of Sampled Functions, Theory of Computing 8 (2012).
class LowerEnvelope {
public:
    explicit LowerEnvelope(double step) : step_(step) {}

    void run(std::span<double> line, std::size_t stride, std::size_t count) {
        apexes_.clear();
        const auto height = [&](std::size_t i) { return line[i * stride]; };
        const auto position = [&](std::size_t i) { return static_cast<double>(i) * step_; };
        for (std::size_t i = 0; i < count; ++i) {
            if (height(i) == std::numeric_limits<double>::infinity()) continue;
            double start = -std::numeric_limits<double>::infinity();
            while (!apexes_.empty()) {
                const std::size_t last = apexes_.back().cell;
                const double apart = position(i) - position(last);
                start =
                    (height(i) - apexes_.back().height + position(i) * position(i) - position(last) * position(last)) /
                    (2 * apart);
                if (start > apexes_.back().start) break;
                apexes_.pop_back();
                start = -std::numeric_limits<double>::infinity();
            }
            apexes_.push_back({i, height(i), start});
        }
        for (std::size_t i = 0, apex = 0; i < count && !apexes_.empty(); ++i) {
            while (apex + 1 < apexes_.size() && apexes_[apex + 1].start <= position(i)) ++apex;
            const double apart = position(i) - position(apexes_[apex].cell);
            line[i * stride] = apexes_[apex].height + apart * apart;
        }
    }

private:
    struct Apex {
        std::size_t cell;
        double height;
        double start;  ///< position from which on its parabola is the lowest one
    };
    double step_;
    std::vector<Apex> apexes_;
};

/// Returns the sine cardinal, sin(pi x) / (pi x).
double sinc(double x) {
    const double angle = std::numbers::pi * x;
    return std::abs(angle) < 1e-8 ? 1 : elementary::sin(angle) / angle;
}

std::vector<BorderEdge> border_of(const Domain& domain) {
    std::vector<BorderEdge> border;
    for (const Ring& ring : domain.rings()) {
        Point last = ring.back();
        for (const Point& corner : ring) {
            border.push_back({last, corner});
            last = corner;
        }
    }
    return border;
}

}  // namespace

PolygonTaper::PolygonTaper(const Domain& domain) : PolygonTaper(domain, cell_of(domain)) {}

PolygonTaper::PolygonTaper(const Domain& domain, double cell)
    : columns_(cells_along(domain.unit_bounds().max.x, cell)),
      rows_(cells_along(domain.unit_bounds().max.y, cell)),
      transform_({columns_, rows_, 1}) {
    const Point sides = domain.unit_bounds().max;
    const auto columns = static_cast<std::size_t>(columns_), rows = static_cast<std::size_t>(rows_);
    depths_ = coverage(border_of(domain), sides, columns_, rows_);
    constexpr double kCovered = 1 - 1e-9;
    for (double& depth : depths_) depth = depth > kCovered ? std::numeric_limits<double>::infinity() : 0;
    const double unit = std::sqrt(sides.x * sides.y);
    const double width = sides.x / columns_ / unit, height = sides.y / rows_ / unit;
    LowerEnvelope across(width), up(height);
    for (std::size_t y = 0; y < rows; ++y) across.run(std::span(depths_).subspan(y * columns), 1, columns);
    for (std::size_t x = 0; x < columns; ++x) up.run(std::span(depths_).subspan(x), columns, rows);
    cell_ = std::max(width, height);
    for (std::size_t y = 0; y < rows; ++y) {
        for (std::size_t x = 0; x < columns; ++x) {
            double& depth = depths_[y * columns + x];
            // All around the grid is outside, too.
            const double to_side = width * (static_cast<double>(std::min(x, columns - 1 - x)) + 1);
            const double to_end = height * (static_cast<double>(std::min(y, rows - 1 - y)) + 1);
            depth = std::max(0.0, std::min({std::sqrt(depth), to_side, to_end}) - cell_);
            if (depth > 0) sorted_.push_back(depth);
        }
    }
    std::ranges::sort(sorted_);
    if (!is_wide_enough()) return;
    weights_.reserve(depths_.size());
    for (const double depth : depths_) {
        const double sine = elementary::sin(std::numbers::pi / 2 * depth / sorted_.back());
        weights_.push_back(sine * sine);
    }
    std::ranges::copy(weights_, transform_.grid().begin());
    transform_.forward();
}

bool PolygonTaper::is_wide_enough() const {
    return !sorted_.empty() && sorted_.back() >= kMinCellsPerDepth * cell_;
}

double PolygonTaper::share_at_depth(double depth) const {
    const auto deeper = sorted_.end() - std::ranges::lower_bound(sorted_, depth);
    return static_cast<double>(deeper) / static_cast<double>(sorted_.size());
}

double PolygonTaper::interpolate(const std::vector<double>& values, Point share) const {
    const double x = share.x * columns_ - 0.5, y = share.y * rows_ - 0.5;
    const double left = std::floor(x), low = std::floor(y);
    const auto value = [&](double column, double row) {
        const bool is_there = column >= 0 && row >= 0 && column < columns_ && row < rows_;
        return is_there ? values[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_) +
                                 static_cast<std::size_t>(column)]
                        : 0;
    };
    const double right_share = x - left, high_share = y - low;
    const double below = (1 - right_share) * value(left, low) + right_share * value(left + 1, low);
    const double above = (1 - right_share) * value(left, low + 1) + right_share * value(left + 1, low + 1);
    return (1 - high_share) * below + high_share * above;
}

std::complex<double> PolygonTaper::transform(int i, int j) const {
    const double x = static_cast<double>(i) / columns_, y = static_cast<double>(j) / rows_;
    const auto column_of = [&](int frequency) { return (frequency % columns_ + columns_) % columns_; };
    int column = column_of(i), row = (j % rows_ + rows_) % rows_;
    const bool is_stored = column <= columns_ / 2;
    if (!is_stored) {
        column = columns_ - column;
        row = (rows_ - row) % rows_;
    }
    const auto stored =
        transform_.spectrum()[static_cast<std::size_t>(row) * static_cast<std::size_t>(columns_ / 2 + 1) +
                              static_cast<std::size_t>(column)];
    // The centres of cells are half a cell away from the corner of the box. Linear interpolation convolves by a
    // triangle, whose transform is the square of sinc.
    const double angle = -std::numbers::pi * (x + y), tent = sinc(x) * sinc(x) * sinc(y) * sinc(y);
    const std::complex<double> shift{elementary::cos(angle), elementary::sin(angle)};
    return (is_stored ? stored : std::conj(stored)) * shift * (tent / columns_ / rows_);
}

}  // namespace ccdt
