// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>

#include "core/base/elementary.h"
#include "core/base/lanes.h"
#include "core/base/pair.h"
#include "core/ccdt/polish/grid_frame.h"
#include "core/geometry/point.h"
#include "core/geometry/spreading.h"

namespace ccdt {

/// The kernel of a WaveGrid in the plane: quintic B-splines along both axes. For frequencies up to a fifth of a cycle
/// per cell, the error consists of aliases of higher frequencies, each with less than 3e-4 of the original amplitude.
/// BasicWaveGrid documents the functions.
class SplineKernel {
public:
    static constexpr std::size_t kPointsPerTask = 8192;
    static constexpr std::size_t kBand = 16;  ///< least number of rows in a band; more than the taps reach

    /// @param values  of the padded grid
    SplineKernel(const GridFrame<Point>& frame, double* values)
        : frame_(frame),
          half_cell_{0.5 / frame.cells[0], 0.5 / frame.cells[1]},
          stride_(frame.padded(0)),
          values_(values) {}

    /// Returns the spectrum of the kernel along an axis.
    static double window(double periods, int cells) {
        return elementary::pow(sinc(periods / cells), static_cast<double>(kTaps));
    }

    /// Returns the padded row of the first taps of a point.
    std::size_t first_layer(Point p) const { return positions<OneLane>({p}).rows[0]; }

    /// @param numbers  indices of the points to spread
    void spread(std::span<const Point> points, std::span<const double> values,
                std::span<const std::uint32_t> numbers) const {
        in_lanes(numbers.size(), [&]<class Lanes>(Lanes, std::size_t first) CCDT_INLINE {
            std::array<Point, Lanes::kCount> few;
            std::array<double, Lanes::kCount> of_few;
            for (std::size_t lane = 0; lane < Lanes::kCount; ++lane) {
                few[lane] = points[numbers[first + lane]];
                of_few[lane] = values.empty() ? 1 : values[numbers[first + lane]];
            }
            spread_few<Lanes>(few, of_few);
        });
    }

    void spread_move(Point p, Point move) const {
        const auto [rows, first, fraction] = positions<OneLane>({p});
        const Taps<Pair> weights = b_spline<kDegree>(fraction), slopes = slopes_at(fraction);
        const Point cell = frame_.cell();
        std::array<double, kTaps> along_x, across;
        for (std::size_t i = 0; i < kTaps; ++i) {
            along_x[i] = move.x / cell.x * slopes[i][0];
            across[i] = move.y / cell.y * weights[i][0];
        }
        for (std::size_t j = 0; j < kTaps; ++j) {
            double* row = values_ + first[0] + j * stride_;
            const double weight = weights[j][1], slope = slopes[j][1];
            for (std::size_t i = 0; i < kTaps; ++i) row[i] += weight * along_x[i] + slope * across[i];
        }
    }

    void gradients(std::span<const Point> points, std::span<Point> gradients) const {
        in_lanes(points.size(), [&]<class Lanes>(Lanes, std::size_t first) CCDT_INLINE {
            std::array<Point, Lanes::kCount> few;
            std::copy_n(&points[first], Lanes::kCount, few.begin());
            few = gradients_of<Lanes>(few);
            std::copy_n(few.begin(), Lanes::kCount, &gradients[first]);
        });
    }

private:
    /// Calls visit(lanes, index of the first one) for as many points at once as the processor supports.
    /// @param visit  marked CCDT_INLINE
    template <class Visit>
    static void in_lanes(std::size_t points, Visit&& visit) {
        const std::size_t in_pairs = points / 2 * 2;
        with_lanes([&](auto lanes) CCDT_INLINE {
            for (std::size_t i = 0; i < in_pairs; i += decltype(lanes)::kCount) visit(lanes, i);
        });
        if (in_pairs < points) visit(OneLane{}, in_pairs);
    }

    static constexpr int kDegree = 5;
    static constexpr std::size_t kTaps = kDegree + 1;

    /// Values of the B-spline at the six grid points around a position, along both axes. Each value is a vector with a
    /// pair (x, y) for each of the points that are processed together.
    template <class Pairs>
    using Taps = std::array<Pairs, kTaps>;

    /// Returns the slopes of the quintic B-spline at the six grid points around a position.
    template <class Pairs>
    CCDT_INLINE static Taps<Pairs> slopes_at(Pairs f) {
        const auto outer = [](Pairs d) CCDT_INLINE {
            const Pairs g = 1.0 - d, g2 = g * g;
            return g2 * g2 * (-1.0 / 24);
        };
        const auto inner = [](Pairs d) CCDT_INLINE {
            const Pairs x = 1.0 + d;
            return 5.0 / 8 + x * (-7.0 / 2 + x * (15.0 / 4 + x * (-3.0 / 2 + x * (5.0 / 24))));
        };
        const auto middle = [](Pairs d) CCDT_INLINE { return d * (-1.0 + d * d * (1.0 - d * (5.0 / 12))); };
        const Pairs g = 1.0 - f;
        return {outer(f), inner(f), middle(f), -middle(g), -inner(g), -outer(g)};
    }

    /// The six successive values that the taps of a point cover in a row.
    template <class Lanes>
    struct Row {
        typename Lanes::Pairs low{};
        std::array<Pair, kTaps / 2 - Lanes::kCount> high{};

        CCDT_INLINE static Row of(const std::array<Pair, kTaps / 2>& pairs) {
            Row row;
            std::array<Pair, Lanes::kCount> low;
            std::copy_n(pairs.begin(), low.size(), low.begin());
            row.low = Lanes::join(low);
            std::copy_n(pairs.begin() + low.size(), row.high.size(), row.high.begin());
            return row;
        }
        CCDT_INLINE std::array<Pair, kTaps / 2> pairs() const {
            std::array<Pair, kTaps / 2> pairs;
            for (std::size_t lane = 0; lane < Lanes::kCount; ++lane) pairs[lane] = Lanes::pair(low, lane);
            std::copy_n(high.begin(), high.size(), pairs.begin() + Lanes::kCount);
            return pairs;
        }
        CCDT_INLINE static Row load(const double* values) {
            Row row;
            std::memcpy(&row.low, values, sizeof row.low);
            std::memcpy(row.high.data(), values + 2 * Lanes::kCount, sizeof row.high);
            return row;
        }
        CCDT_INLINE void store(double* values) const {
            std::memcpy(values, &low, sizeof low);
            std::memcpy(values + 2 * Lanes::kCount, high.data(), sizeof high);
        }
        CCDT_INLINE void add(double factor, const Row& row) {
            low += factor * row.low;
            for (std::size_t i = 0; i < high.size(); ++i) high[i] += factor * row.high[i];
        }
    };

    /// Returns the weights of the six taps along x. Each vector holds the weights of two successive taps for each
    /// point.
    template <class Lanes>
    CCDT_INLINE static std::array<typename Lanes::Pairs, kTaps / 2> across(const Taps<typename Lanes::Pairs>& taps) {
        return {Lanes::firsts(taps[0], taps[1]), Lanes::firsts(taps[2], taps[3]), Lanes::firsts(taps[4], taps[5])};
    }

    /// Positions of points in the padded grid. A point has taps in six columns and six rows, three on each side of the
    /// point. `fractions` is the offset of each point, in cells, from the third column and the third row.
    template <class Lanes>
    struct Positions {
        std::array<std::size_t, Lanes::kCount> rows;   ///< first row of the taps
        std::array<std::size_t, Lanes::kCount> first;  ///< index of the first tap
        typename Lanes::Pairs fractions;
    };

    /// Determines the grid points on which points are spread. On a torus, grid points are at the corners of cells, as
    /// in the Fourier transform. In a box, they are at the centres.
    template <class Lanes>
    CCDT_INLINE Positions<Lanes> positions(const std::array<Point, Lanes::kCount>& points) const {
        using Pairs = typename Lanes::Pairs;
        const auto of_each = [](Pair pair) CCDT_INLINE {
            std::array<Pair, Lanes::kCount> same;
            same.fill(pair);
            return Lanes::join(same);
        };
        std::array<Pair, Lanes::kCount> coordinates;
        for (std::size_t lane = 0; lane < Lanes::kCount; ++lane) coordinates[lane] = load(points[lane]);
        const Pairs share = Lanes::join(coordinates) / of_each(load(frame_.sides));
        const Pairs cells = of_each(Pair{static_cast<double>(frame_.cells[0]), static_cast<double>(frame_.cells[1])});
        const Pairs none{}, all = none + 1.0;
        const Pairs clamped = share < none ? none : all < share ? all : share;
        const Pairs at = (frame_.torus ? share - Lanes::whole(share) : clamped - of_each(half_cell_)) * cells;
        // Rounding can put a position at the far end of a torus.
        const Pairs last = cells - 1.0, below = Lanes::whole(at), before = last < below ? last : below;
        Positions<Lanes> positions;
        positions.fractions = at - before;
        for (std::size_t lane = 0; lane < Lanes::kCount; ++lane) {
            const Pair point = Lanes::pair(before, lane) + 1.0;
            positions.rows[lane] = static_cast<std::size_t>(point[1]);
            positions.first[lane] = positions.rows[lane] * stride_ + static_cast<std::size_t>(point[0]);
        }
        return positions;
    }

    template <class Lanes>
    CCDT_INLINE void spread_few(const std::array<Point, Lanes::kCount>& points,
                                const std::array<double, Lanes::kCount>& values) const {
        const auto [rows, first, fractions] = positions<Lanes>(points);
        const auto weights = b_spline<kDegree>(fractions);
        const auto columns = across<Lanes>(weights);
        for (std::size_t lane = 0; lane < Lanes::kCount; ++lane) {
            std::array<Pair, kTaps / 2> shares;
            for (std::size_t i = 0; i < shares.size(); ++i) shares[i] = values[lane] * Lanes::pair(columns[i], lane);
            const auto share = Row<Lanes>::of(shares);
            double* taps = values_ + first[lane];
            for (std::size_t j = 0; j < kTaps; ++j, taps += stride_) {
                auto row = Row<Lanes>::load(taps);
                row.add(weights[j][2 * lane + 1], share);
                row.store(taps);
            }
        }
    }

    template <class Lanes>
    CCDT_INLINE std::array<Point, Lanes::kCount> gradients_of(const std::array<Point, Lanes::kCount>& points) const {
        using Pairs = typename Lanes::Pairs;
        const auto [rows, first, fractions] = positions<Lanes>(points);
        const auto weights = b_spline<kDegree>(fractions), slopes = slopes_at(fractions);
        // Sums over columns; each vector holds two successive columns of each point.
        std::array<std::array<Pair, Lanes::kCount>, kTaps / 2> weighted, sloping;
        for (std::size_t lane = 0; lane < Lanes::kCount; ++lane) {
            Row<Lanes> along_y, slope_y;
            const double* values = values_ + first[lane];
            for (std::size_t j = 0; j < kTaps; ++j, values += stride_) {
                const auto row = Row<Lanes>::load(values);
                along_y.add(weights[j][2 * lane + 1], row);
                slope_y.add(slopes[j][2 * lane + 1], row);
            }
            const auto along_pairs = along_y.pairs(), slope_pairs = slope_y.pairs();
            for (std::size_t i = 0; i < kTaps / 2; ++i) {
                weighted[i][lane] = along_pairs[i];
                sloping[i][lane] = slope_pairs[i];
            }
        }
        Pairs sum{};
        for (std::size_t i = 0; i < kTaps; i += 2) {
            const Pairs along = Lanes::join(weighted[i / 2]), slope = Lanes::join(sloping[i / 2]);
            sum += Lanes::firsts(along, slope) * Lanes::firsts(slopes[i], weights[i]);
            sum += Lanes::seconds(along, slope) * Lanes::firsts(slopes[i + 1], weights[i + 1]);
        }
        const Point cell = frame_.cell();
        std::array<Point, Lanes::kCount> gradients;
        for (std::size_t lane = 0; lane < Lanes::kCount; ++lane) {
            const Pair gradient = Lanes::pair(sum, lane);
            gradients[lane] = {gradient[0] / cell.x, gradient[1] / cell.y};
        }
        return gradients;
    }

    GridFrame<Point> frame_;
    Pair half_cell_;      ///< half a cell relative to the box's sides
    std::size_t stride_;  ///< number of values in a row of the padded grid
    double* values_;
};

}  // namespace ccdt
