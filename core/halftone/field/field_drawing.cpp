// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/field/field_drawing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>

#include "core/base/elementary.h"
#include "core/halftone/dots/dot_rounding.h"
#include "core/halftone/dots/level_outline.h"
#include "core/halftone/dots/ring_reduction.h"
#include "core/picture/bilinear.h"
#include "core/picture/blur.h"
#include "core/picture/pixel_ranges.h"

namespace ccdt {

namespace {

std::size_t size_of(const CellGrid& cells) {
    return static_cast<std::size_t>(cells.columns) * static_cast<std::size_t>(cells.rows);
}

/// Interpolates the values of one grid at the centres of the cells of another grid.
class Resampling {
public:
    /// Both grids cover the same box.
    Resampling(const CellGrid& from, const CellGrid& to)
        : Resampling(from, to, static_cast<double>(from.columns) / to.columns,
                     static_cast<double>(from.rows) / to.rows) {}

    /// Both grids have a common upper left corner.
    /// @param across, down  size of a cell of `to`, in cells of `from`
    Resampling(const CellGrid& from, const CellGrid& to, double across, double down)
        : from_(from), is_identity_(from == to) {
        for (int x = 0; x < to.columns; ++x) across_.emplace_back((x + 0.5) * across, from.columns);
        for (int y = 0; y < to.rows; ++y) down_.emplace_back((y + 0.5) * down, from.rows);
    }

    /// Interpolates a row of the other grid.
    void row(const std::vector<float>& values, std::size_t y, float* out) const {
        if (is_identity_) {
            std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(y * across_.size()), across_.size(), out);
            return;
        }
        const auto& [upper_row, lower_row, down] = down_[y];
        const float* const upper = values.data() + upper_row * static_cast<std::size_t>(from_.columns);
        const float* const lower = values.data() + lower_row * static_cast<std::size_t>(from_.columns);
        for (std::size_t x = 0; x < across_.size(); ++x) {
            const auto& [first, second, share] = across_[x];
            out[x] = mix(mix(upper[first], upper[second], share), mix(lower[first], lower[second], share), down);
        }
    }

    std::vector<float> operator()(const std::vector<float>& values, Executor& executor) const {
        std::vector<float> result(across_.size() * down_.size());
        for_rows(executor, static_cast<int>(across_.size()), down_.size(),
                 [&](std::size_t y) { row(values, y, result.data() + y * across_.size()); });
        return result;
    }

private:
    CellGrid from_;
    bool is_identity_;
    std::vector<BetweenPixels> across_, down_;
};

/// The local spacing of the sites of a plan.
class Spacings {
public:
    Spacings(const FieldPlan& plan, Executor& executor)
        : plan_(plan),
          executor_(executor),
          density_(blurred(plan.density, plan.cells.columns, plan.cells.rows, plan.pitch(), executor)),
          mean_(sum_of_pixels(executor, plan.density.size(),
                              [&](std::size_t i) { return static_cast<double>(plan.density[i]); }) /
                static_cast<double>(plan.density.size())) {}

    /// Returns the spacing of sites around each cell of a grid, in cells of this grid. The spacings are limited to a
    /// range around the mean spacing.
    std::vector<float> in(const CellGrid& grid) const {
        constexpr double kNarrow = 0.7, kWide = 1.4, kWideIfLimited = 4;
        const double pitch = std::sqrt(static_cast<double>(size_of(grid)) / std::max(plan_.sites, 1.0));
        const double wide = plan_.is_limited ? kWideIfLimited : kWide;
        auto lengths = Resampling(plan_.cells, grid)(density_, executor_);
        for_pixels(executor_, lengths.size(), [&](std::size_t i) {
            const double density = mean_ > 0 ? std::max(static_cast<double>(lengths[i]) / mean_, 1e-6) : 1;
            lengths[i] = static_cast<float>(pitch * std::clamp(1 / std::sqrt(density), kNarrow, wide));
        });
        return lengths;
    }

private:
    const FieldPlan& plan_;
    Executor& executor_;
    std::vector<float> density_;  ///< [plan's cells] around each cell
    double mean_;
};

/// Blurs errors of ink over distances that follow the local spacing of sites.
class ErrorBlur {
public:
    /// @param cells  of the errors
    ErrorBlur(const FieldPlan& plan, const CellGrid& cells, Executor& executor) : cells_(cells), executor_(executor) {
        constexpr double kMinIfHalved = 3.3;  // cells
        const CellGrid half{(cells.columns + 1) / 2, (cells.rows + 1) / 2};
        const Spacings spacings(plan, executor);
        const auto narrowest = [&] { return static_cast<double>(*std::ranges::min_element(step_)); };
        step_ = spacings.in(half);
        grid_ = 2 * narrowest() < kMinIfHalved ? cells : half;
        if (grid_ == cells) step_ = spacings.in(cells);
        least_ = narrowest();
        const auto of = [least = static_cast<float>(least_)](float length) { return elementary::log2(length / least); };
        steps_ = static_cast<int>(std::ceil(of(*std::ranges::max_element(step_)))) + 1;
        for_pixels(executor, step_.size(), [&](std::size_t i) { step_[i] = of(step_[i]); });
    }

    /// Returns the way from blurred errors to the cells.
    Resampling back() const { return {grid_, cells_, 1 / scale(), 1 / scale()}; }

    /// Returns blurred errors [grid].
    /// @param errors  errors(y, row) writes a row of errors [cells.columns]
    /// @param reach   standard deviation of the Gaussian, in spacings
    /// @param gain    factor of the result
    template <class Errors>
    std::vector<float> operator()(const Errors& errors, double reach, float gain) {
        constexpr double kMin = 1.5;  // cells
        const double sigma = std::max(reach * least_, kMin / scale());
        std::vector<float> values(size_of(grid_));
        if (grid_ == cells_) {
            const auto columns = static_cast<std::size_t>(cells_.columns);
            for_rows(executor_, cells_.columns, static_cast<std::size_t>(cells_.rows),
                     [&](std::size_t y) { errors(y, values.data() + y * columns); });
            widen(values, sigma);
        } else {
            halve(errors, values);
            widen(values, std::sqrt(sigma * sigma - kVariance));
        }
        std::vector<float> result(values.size());
        for (int step = 0; step < steps_; ++step) {
            for_pixels(executor_, result.size(), [&](std::size_t i) {
                const float weight = 1 - std::abs(step_[i] - static_cast<float>(step));
                result[i] += gain * std::max(weight, 0.0f) * values[i];
            });
            if (step + 1 < steps_) widen(values, elementary::exp2(step) * sigma * std::numbers::sqrt3);
        }
        return result;
    }

private:
    /// Returns the size of the cells of the grid, in cells of the errors.
    double scale() const { return grid_ == cells_ ? 1 : 2; }

    /// Variance of the filter of halve(), in squared cells of the grid.
    static constexpr double kVariance = 0.75 / 4;

    /// Halves errors along both axes, with the weights 1, 3, 3, 1: hardly anything of the dots' texture becomes
    /// coarser.
    template <class Errors>
    void halve(const Errors& errors, std::vector<float>& values) const {
        const auto columns = static_cast<std::size_t>(cells_.columns), half = static_cast<std::size_t>(grid_.columns);
        const auto weigh = [](float a, float b, float c, float d) { return (a + d + 3 * (b + c)) / 8; };
        for_ranges(executor_, static_cast<std::size_t>(grid_.rows), rows_of_task(cells_.columns),
                   [&](std::size_t begin, std::size_t end) {
                       std::array<std::vector<float>, 4> rows;  // the last ones, in turns
                       rows.fill(std::vector<float>(columns));
                       std::vector<float> sums(columns + 3);  // with one more cell before the row and two after it
                       const auto read = [&](std::size_t number) {  // of the row, plus one
                           const std::size_t y = std::min(std::max<std::size_t>(number, 1) - 1,
                                                          static_cast<std::size_t>(cells_.rows) - 1);
                           errors(y, rows[number % 4].data());
                       };
                       read(2 * begin);
                       read(2 * begin + 1);
                       for (std::size_t y = begin; y < end; ++y) {
                           read(2 * y + 2);
                           read(2 * y + 3);
                           const auto row = [&](std::size_t i) { return rows[(2 * y + i) % 4].data(); };
                           const float *a = row(0), *b = row(1), *c = row(2), *d = row(3);
                           for (std::size_t x = 0; x < columns; ++x) sums[x + 1] = weigh(a[x], b[x], c[x], d[x]);
                           sums[0] = sums[1];
                           sums[columns + 1] = sums[columns + 2] = sums[columns];
                           float* const out = values.data() + y * half;
                           for (std::size_t x = 0; x < half; ++x)
                               out[x] = weigh(sums[2 * x], sums[2 * x + 1], sums[2 * x + 2], sums[2 * x + 3]);
                       }
                   });
    }

    void widen(std::vector<float>& values, double sigma) {
        constexpr double kFew = 6;  // cells
        (sigma < kFew ? blur_directly : blur)(values, grid_.columns, grid_.rows, sigma, scratch_, executor_);
    }

    CellGrid cells_;
    CellGrid grid_{};  ///< of blurred errors: the cells or, if spacings have many cells, blocks of two by two
    Executor& executor_;
    double least_ = 0;         ///< smallest spacing, in cells of the grid
    int steps_ = 0;            ///< number of widths, each twice the one before
    std::vector<float> step_;  ///< [grid] number of the local width, in [0, steps - 1]
    std::vector<float> scratch_;
};

/// Returns the share of a pixel in which the spot function exceeds the threshold.
/// @param above  spot function minus threshold, at the centre
/// @param slope  change of this difference per pixel, > 0
float ink_share(float above, float slope) {
    return std::clamp(0.5f + above / slope, 0.0f, 1.0f);
}

/// Rows of an image around one row, for differences across it.
struct ThreeRows {
    const float *upper, *row, *lower;
    float least;  ///< slope of the spot function within a pixel at its peaks

    /// Returns the length of the gradient at a pixel, as a central difference, or the least slope.
    float slope(std::size_t x, std::size_t columns) const {
        const float across = row[std::min(x + 1, columns - 1)] - row[x > 0 ? x - 1 : x];
        const float down = lower[x] - upper[x];
        return std::max(std::sqrt(across * across + down * down) / 2, least);
    }
};

/// Thresholds of solid ink and of bare paper.
constexpr float kSolid = -2, kBare = 3;

/// Fits the threshold of a channel.
class Fit {
public:
    /// @param spots  [cells] spot function
    /// @param start  [cells] threshold before the fit of any channel
    /// @param first  [cells] threshold before the fit of this channel
    /// @param light  [cells] wanted light
    /// @param most   [cells] upper limit of the threshold; empty: none
    Fit(const CellGrid& cells, const std::vector<float>& spots, const std::vector<float>& start,
        std::vector<float> first, std::vector<float> light, std::span<const float> most, float least_slope,
        Executor& executor)
        : cells_(cells),
          spots_(spots),
          light_(std::move(light)),
          most_(most),
          threshold_(std::move(first)),
          slope_(start.size()),
          executor_(executor) {
        find_slopes(start, least_slope);
        for_ranges(executor, threshold_.size(), kPixelsOfTask,
                   [&](std::size_t begin, std::size_t end) { limit(begin, end); });
    }

    /// Measures the error of the ink, and moves the threshold.
    /// @param ink  [cells] share of ink; empty: it follows from the threshold and the slope
    void round(std::span<const float> ink, ErrorBlur& blur, double reach, float gain) {
        const auto columns = static_cast<std::size_t>(cells_.columns);
        const auto errors = [&](std::size_t y, float* row) {
            const std::size_t first = y * columns;
            if (ink.empty()) {
                for (std::size_t x = 0; x < columns; ++x)
                    row[x] = ink_share(spots_[first + x] - threshold_[first + x], slope_[first + x]);
            } else {
                std::ranges::copy(ink.subspan(first, columns), row);
            }
            for (std::size_t x = 0; x < columns; ++x) row[x] -= 1 - light_[first + x];
        };
        const std::vector<float> change = blur(errors, reach, gain);
        const Resampling resampling = blur.back();
        for_ranges(executor_, static_cast<std::size_t>(cells_.rows), rows_of_task(cells_.columns),
                   [&](std::size_t begin, std::size_t end) {
                       std::vector<float> row(columns);
                       for (std::size_t y = begin; y < end; ++y) {
                           resampling.row(change, y, row.data());
                           for (std::size_t x = 0; x < columns; ++x) threshold_[y * columns + x] += row[x];
                           limit(y * columns, (y + 1) * columns);
                       }
                   });
    }

    std::vector<float>& threshold() { return threshold_; }

    /// Returns the threshold minus the spot function, which is at most 0 where ink lies.
    std::vector<float> level() const {
        std::vector<float> values(spots_.size());
        for_pixels(executor_, values.size(), [&](std::size_t i) { values[i] = threshold_[i] - spots_[i]; });
        return values;
    }

private:
    /// Keeps the solid ink of some cells free of holes, bare paper free of dots, and the threshold below its limit.
    void limit(std::size_t begin, std::size_t end) {
        constexpr float kNothing = 0.0005f;
        for (std::size_t i = begin; i < end; ++i) {
            const float bounded = light_[i] < kNothing ? kSolid : threshold_[i];
            threshold_[i] = light_[i] > 1 - kNothing ? kBare : bounded;
        }
        if (most_.empty()) return;
        for (std::size_t i = begin; i < end; ++i) threshold_[i] = std::min(threshold_[i], most_[i]);
    }

    void find_slopes(const std::vector<float>& start, float least) {
        const auto columns = static_cast<std::size_t>(cells_.columns), rows = static_cast<std::size_t>(cells_.rows);
        std::vector<float> above(spots_.size());
        for_pixels(executor_, above.size(), [&](std::size_t i) { above[i] = spots_[i] - start[i]; });
        for_rows(executor_, cells_.columns, rows, [&](std::size_t y) {
            const auto row = [&](std::size_t number) { return above.data() + number * columns; };
            const ThreeRows around{row(y > 0 ? y - 1 : y), row(y), row(std::min(y + 1, rows - 1)), least};
            for (std::size_t x = 0; x < columns; ++x) slope_[y * columns + x] = around.slope(x, columns);
        });
    }

    CellGrid cells_;
    const std::vector<float>& spots_;
    std::vector<float> light_;
    std::span<const float> most_;
    std::vector<float> threshold_, slope_;
    Executor& executor_;
};

/// Returns the threshold of a channel before the fit [to].
std::vector<float> start_of(const FieldChannel& channel, const CellGrid& to, const Resampling& resampling,
                            Executor& executor) {
    const auto columns = static_cast<std::size_t>(to.columns);
    std::vector<float> start(size_of(to));
    for_ranges(executor, static_cast<std::size_t>(to.rows), rows_of_task(to.columns),
               [&](std::size_t begin, std::size_t end) {
                   std::vector<float> steepness(columns), low(columns), high(columns);
                   for (std::size_t y = begin; y < end; ++y) {
                       float* const row = start.data() + y * columns;
                       resampling.row(channel.sharp, y, row);
                       resampling.row(channel.steepness, y, steepness.data());
                       resampling.row(channel.low, y, low.data());
                       resampling.row(channel.high, y, high.data());
                       for (std::size_t x = 0; x < columns; ++x)
                           row[x] = steepened(row[x], steepness[x], low[x], high[x]);
                   }
               });
    return start;
}

/// Returns the wanted light of a channel in each cell.
std::vector<float> wanted_light(const FieldChannel& channel, const CellGrid& from, const CellGrid& to,
                                Executor& executor) {
    if (to.columns <= from.columns && to.rows <= from.rows)
        return reduced(channel.light, from.columns, from.rows, to, executor);
    return Resampling(from, to)(channel.light, executor);
}

/// Some rows of a canvas, with the spot function at their pixels.
class Band {
public:
    /// @param begin, end  rows
    /// @param paint       paint(first, end, spots) writes the spot function of some rows
    template <class Paint>
    Band(const CellGrid& canvas, std::size_t begin, std::size_t end, const Paint& paint)
        : columns_(static_cast<std::size_t>(canvas.columns)),
          begin_(begin),
          end_(end),
          first_(begin > 0 ? begin - 1 : 0),
          last_(std::min(end + 1, static_cast<std::size_t>(canvas.rows))),
          spots_((last_ - first_) * columns_),
          above_(spots_.size()),
          threshold_(columns_) {
        paint(first_, last_, std::span(spots_));
    }

    /// Draws the darker side of a channel.
    /// @param start, threshold  [cells] before and after the fit
    /// @param soft              whether pixels have shares of ink; if not, they have ink if their centre has
    void draw(const std::vector<float>& start, const std::vector<float>& threshold, const Resampling& resampling,
              float least_slope, bool soft, Raster& raster) {
        for (std::size_t y = first_; y < last_; ++y) {
            float* const above = row(above_, y);
            resampling.row(start, y, above);
            for (std::size_t x = 0; x < columns_; ++x) above[x] = row(spots_, y)[x] - above[x];
        }
        for (std::size_t y = begin_; y < end_; ++y) {
            const ThreeRows around{row(above_, std::max(y, first_ + 1) - 1), row(above_, y),
                                   row(above_, std::min(y + 1, last_ - 1)), least_slope};
            const float* const spots = row(spots_, y);
            resampling.row(threshold, y, threshold_.data());
            std::uint8_t* const out = raster.coverage.data() + y * columns_;
            for (std::size_t x = 0; x < columns_; ++x) {
                const float higher = spots[x] - threshold_[x];
                const float share = soft ? ink_share(higher, around.slope(x, columns_)) : higher > 0 ? 1.0f : 0.0f;
                out[x] = static_cast<std::uint8_t>(255 * share + 0.5f);
            }
        }
    }

private:
    float* row(std::vector<float>& values, std::size_t y) { return values.data() + (y - first_) * columns_; }

    std::size_t columns_, begin_, end_, first_, last_;
    std::vector<float> spots_, above_, threshold_;
};

Raster blank(const CellGrid& canvas) {
    return {canvas.columns, canvas.rows, 0, std::vector<std::uint8_t>(size_of(canvas))};
}

/// Returns the cells of the fit: the pixels of the canvas or, if triangles have many pixels, fewer and larger cells.
CellGrid fit_cells(const FieldPlan& plan, const CellGrid& canvas) {
    const double scale = static_cast<double>(canvas.columns) / plan.cells.columns;
    const double share = std::min(plan.sites > 0 ? kPixelsOfPitch / (plan.pitch() * scale) : 1 / scale, 1.0);
    const auto along = [share](int pixels) { return std::max(static_cast<int>(std::lround(share * pixels)), 1); };
    return {along(canvas.columns), along(canvas.rows)};
}

/// Returns cells in which outlines are precise: kPixelsOfPitch cells per spacing of sites, and at least as many cells
/// as the plan has, but at most 16 million.
CellGrid outline_cells(const FieldPlan& plan) {
    constexpr double kMax = 16e6;
    const double cells = static_cast<double>(plan.cells.columns) * plan.cells.rows;
    const double wanted = std::max(plan.sites * kPixelsOfPitch * kPixelsOfPitch, cells);
    const double scale = std::sqrt(std::min(wanted, kMax) / cells);
    const auto along = [scale](int side) { return std::max(static_cast<int>(std::lround(scale * side)), 1); };
    return {along(plan.cells.columns), along(plan.cells.rows)};
}

}  // namespace

FieldDrawing::FieldDrawing(const FieldPlan& plan, std::span<const Point> sites, const std::optional<CellGrid>& canvas,
                           const std::stop_token& stop, Executor& executor)
    : is_nested_(!plan.sets.empty()),
      pitch_(plan.pitch() / plan.cells.columns),
      triangles_(sites, {{0, 0}, {static_cast<double>(plan.cells.columns), static_cast<double>(plan.cells.rows)}}),
      cells_(canvas ? fit_cells(plan, *canvas) : outline_cells(plan)),
      spots_(SpotField(triangles_, cells_).values(executor)),
      executor_(executor) {
    // The last rounds measure what is drawn, and blur it so widely that no texture of dots is left: the threshold would
    // follow it, which makes dark areas darker and light ones lighter.
    constexpr int kRounds = 6, kLast = 2, kLastIfDrawn = 3;
    constexpr double kReach = 0.55, kWideReach = 0.9;  // spacings
    constexpr float kFirstGain = 1.9f, kLastGain = 0.5f;
    const Resampling resampling(plan.cells, cells_);
    ErrorBlur blur(plan, cells_, executor);
    const bool is_drawn = cells_ != canvas;  // whether ink is measured in other pixels than the cells
    for (const FieldChannel& channel : plan.channels) {
        std::vector<float> start = start_of(channel, cells_, resampling, executor);
        std::vector<float> first = start;
        std::span<const float> most;
        if (is_nested_ && !thresholds_.empty()) {
            // Begins with the corrections of the boundary before.
            most = thresholds_.back();
            for_pixels(executor, first.size(), [&](std::size_t i) {
                if (most[i] < kBare) first[i] = std::min(first[i] + most[i] - starts_.back()[i], most[i]);
            });
        }
        Fit fit(cells_, spots_, start, std::move(first), wanted_light(channel, plan.cells, cells_, executor), most,
                least_slope(cells_.columns), executor);
        for (int round = 0; round < kRounds && !stop.stop_requested(); ++round) {
            const float gain = std::lerp(kFirstGain, kLastGain, static_cast<float>(round) / (kRounds - 1));
            fit.round({}, blur, kReach, gain);
        }
        for (int round = 0; round < (is_drawn ? kLastIfDrawn : kLast) && !stop.stop_requested(); ++round) {
            std::vector<float> ink;
            if (is_drawn)
                ink = canvas ? drawn_ink(start, fit.threshold(), *canvas)
                             : outlined_shares(fit.level(), cells_, executor);
            fit.round(ink, blur, kWideReach, 1);
        }
        starts_.push_back(std::move(start));
        thresholds_.push_back(std::move(fit.threshold()));
    }
}

template <class Draw>
void FieldDrawing::for_bands(const CellGrid& canvas, const Draw& draw) const {
    std::optional<SpotField> field;
    if (canvas != cells_) field.emplace(triangles_, canvas);
    const auto columns = static_cast<std::size_t>(canvas.columns);
    const auto paint = [&](std::size_t first, std::size_t end, std::span<float> spots) {
        if (field) return field->paint(static_cast<int>(first), static_cast<int>(end), spots);
        std::ranges::copy(std::span(spots_).subspan(first * columns, (end - first) * columns), spots.begin());
    };
    for_ranges(executor_, static_cast<std::size_t>(canvas.rows), SpotField::kRowsOfBand,
               [&](std::size_t begin, std::size_t end) { draw(Band(canvas, begin, end, paint), begin, end); });
}

std::vector<float> FieldDrawing::drawn_ink(const std::vector<float>& start, const std::vector<float>& threshold,
                                           const CellGrid& canvas) const {
    Raster raster = blank(canvas);
    const Resampling resampling(cells_, canvas);
    for_bands(canvas, [&](Band band, std::size_t, std::size_t) {
        band.draw(start, threshold, resampling, least_slope(canvas.columns), true, raster);
    });
    std::vector<float> shares(raster.coverage.size());
    for_pixels(executor_, shares.size(),
               [&](std::size_t i) { shares[i] = static_cast<float>(raster.coverage[i]) / 255; });
    return reduced(shares, canvas.columns, canvas.rows, cells_, executor_);
}

void FieldDrawing::nest(std::vector<Raster>& rasters, std::size_t begin, std::size_t end) const {
    for (std::size_t c = 1; c < rasters.size() && is_nested_; ++c) {
        for (std::size_t i = begin; i < end; ++i)
            rasters[c].coverage[i] = std::max(rasters[c].coverage[i], rasters[c - 1].coverage[i]);
    }
}

std::vector<Raster> FieldDrawing::rasters(int width, int height, bool antialias) const {
    // The sizes of larger dots are exact even if each pixel is black or white.
    constexpr double kLarge = 48;
    const bool rounded = !antialias && pitch_ * width < kLarge;
    const CellGrid canvas{width, height};
    const auto columns = static_cast<std::size_t>(width);
    std::vector<Raster> rasters(thresholds_.size(), blank(canvas));
    const Resampling resampling(cells_, canvas);
    for_bands(canvas, [&](Band band, std::size_t begin, std::size_t end) {
        for (std::size_t c = 0; c < rasters.size(); ++c)
            band.draw(starts_[c], thresholds_[c], resampling, least_slope(width), antialias || rounded, rasters[c]);
        nest(rasters, begin * columns, end * columns);
    });
    if (!rounded) return rasters;
    if (is_nested_) {
        std::span<const std::uint8_t> before;
        for (Raster& raster : rasters) {
            round_dots(raster.coverage, width, height, before);
            before = raster.coverage;
        }
    } else {
        executor_.run(rasters.size(), [&](std::size_t c) { round_dots(rasters[c].coverage, width, height); });
    }
    return rasters;
}

std::vector<std::vector<std::vector<Point>>> FieldDrawing::outlines(bool lighter) const {
    constexpr double kDisplacement = 0.01;
    constexpr std::size_t kRingsOfTask = 64;
    std::vector<std::vector<std::vector<Point>>> outlines;
    std::vector<float> level(spots_.size(), 2);
    const double pitch = pitch_ * cells_.columns;
    const Box box{{0, 0}, {static_cast<double>(cells_.columns), static_cast<double>(cells_.rows)}};
    for (const std::vector<float>& threshold : thresholds_) {
        for_pixels(executor_, level.size(), [&](std::size_t i) {
            const float own = lighter ? spots_[i] - threshold[i] : threshold[i] - spots_[i];
            level[i] = is_nested_ ? std::min(level[i], own) : own;
        });
        auto& rings = outlines.emplace_back(outline_of(level, cells_));
        for_ranges(executor_, rings.size(), kRingsOfTask, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i) {
                rings[i] = reduced_ring(rings[i], kDisplacement * pitch * pitch, box);
                for (Point& p : rings[i]) p = {p.x / cells_.columns, p.y / cells_.rows};
            }
        });
        std::erase_if(rings, [](const std::vector<Point>& ring) { return ring.empty(); });
    }
    return outlines;
}

}  // namespace ccdt
