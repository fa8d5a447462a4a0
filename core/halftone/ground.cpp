// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/ground.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <utility>

#include "core/halftone/bilinear.h"
#include "core/halftone/blur.h"
#include "core/halftone/pixel_ranges.h"
#include "core/halftone/srgb.h"
#include "core/halftone/total_variation.h"

namespace ccdt {

namespace {

constexpr float kBoundary = 0.5f;

/// Range of values of Ground::level().
struct LevelRange {
    float low, high;
};

/// Values of Ground::level() along a horizontal line, at the centre of each column of cells.
class LevelRow {
public:
    LevelRow(const Ground& ground, double y)
        : columns_(static_cast<std::size_t>(ground.cells().columns)), level_(columns_), slope_(columns_) {
        const BetweenPixels rows(y, ground.cells().rows);
        const float* upper = ground.level().data() + rows.first * columns_;
        const float* lower = ground.level().data() + rows.second * columns_;
        for (std::size_t c = 0; c < columns_; ++c) {
            level_[c] = mix(upper[c], lower[c], rows.share);
            slope_[c] = lower[c] - upper[c];
        }
    }

    float at(const BetweenPixels& x) const { return mix(level_[x.first], level_[x.second], x.share); }

    /// Returns bounds of the level between two neighbouring cell centres on the line. The bounds also hold within half
    /// a pixel of this part of the line, as antialiasing requires.
    /// @param step  cells per pixel
    LevelRange range(const BetweenPixels& x, Point step) const {
        const float a = level_[x.first], b = level_[x.second];
        const float down = std::max(std::abs(slope_[x.first]), std::abs(slope_[x.second])) * static_cast<float>(step.y);
        const float reach = (std::abs(b - a) * static_cast<float>(step.x) + down) / 2;
        return {std::min(a, b) - reach, std::max(a, b) + reach};
    }

    /// Returns the length of the level's gradient, per pixel.
    /// @param step  cells per pixel
    float steepness(const BetweenPixels& x, Point step) const {
        const float across = (level_[x.second] - level_[x.first]) * static_cast<float>(step.x);
        const float down = mix(slope_[x.first], slope_[x.second], x.share) * static_cast<float>(step.y);
        return std::sqrt(across * across + down * down);
    }

private:
    std::size_t columns_;
    std::vector<float> level_;
    std::vector<float> slope_;  ///< change of the level from one row of cells to the next
};

/// Returns the share of black ground in a pixel, from 0 to 255 (completely black).
/// @param step  cells per pixel
std::uint8_t black_share(const LevelRow& row, const BetweenPixels& x, Point step, bool antialias) {
    const float above = row.at(x) - kBoundary;
    if (!antialias) return above > 0 ? 0 : 255;
    const float steepness = row.steepness(x, step);
    if (std::abs(above) >= steepness / 2) return above > 0 ? 0 : 255;
    return static_cast<std::uint8_t>(std::lrint(255 * (kBoundary - above / steepness)));
}

/// Returns the share of a pixel that ink covers. All shares are from 0 to 255.
/// @param black    share of black ground
/// @param flipped  share that dots flip
std::uint8_t ink_of(unsigned black, unsigned flipped) {
    return static_cast<std::uint8_t>((black * (255 - flipped) + (255 - black) * flipped + 127) / 255);
}

/// Columns of pixels of a canvas, grouped by the two cell centres between which they lie.
class PixelColumns {
public:
    /// @param step  cells per pixel
    PixelColumns(int pixels, double step, int cells) {
        for (int x = 0; x < pixels; ++x) {
            places_.emplace_back((x + 0.5) * step, cells);
            if (x == 0 || places_.back().first != places_[runs_.back()].first) runs_.push_back(places_.size() - 1);
        }
        runs_.push_back(places_.size());
    }

    const BetweenPixels& operator[](std::size_t pixel) const { return places_[pixel]; }

    /// Calls function(begin, end, place) for each range [begin, end) of pixels between the same two cell centres.
    /// `place` is the position of the first of these pixels.
    template <class Function>
    void for_runs(const Function& function) const {
        for (std::size_t run = 0; run + 1 < runs_.size(); ++run)
            function(runs_[run], runs_[run + 1], places_[runs_[run]]);
    }

private:
    std::vector<BetweenPixels> places_;
    std::vector<std::size_t> runs_;
};

/// Converts flipped shares to coverage by ink, for pixels [begin, end) between the same two cell centres. If no
/// boundary is near, all these pixels have the same ground, and one test suffices.
void apply_run(const LevelRow& row, const PixelColumns& columns, std::size_t begin, std::size_t end,
               const BetweenPixels& between, Point step, bool antialias, std::uint8_t* pixels) {
    const LevelRange range = row.range(between, step);
    if (range.low > kBoundary) return;
    if (range.high < kBoundary) {
        for (std::size_t x = begin; x < end; ++x) pixels[x] = static_cast<std::uint8_t>(255 - pixels[x]);
        return;
    }
    for (std::size_t x = begin; x < end; ++x)
        pixels[x] = ink_of(black_share(row, columns[x], step, antialias), pixels[x]);
}

/// Rectangle in a picture, in cells.
struct Part {
    Point low, high;
};

/// Ranges of cells along one axis. Each range contains the cells under one part of the picture, and one more cell on
/// each side.
class CellRanges {
public:
    CellRanges(int cells, int parts) : cells_(cells), parts_(parts) {}

    double begin(std::size_t part) const { return static_cast<double>(part) * cells_ / parts_; }
    std::size_t first(std::size_t part) const { return std::max<std::size_t>(whole(begin(part)), 1) - 1; }
    std::size_t end(std::size_t part) const {
        return std::min(whole(std::ceil(begin(part + 1))) + 1, static_cast<std::size_t>(cells_));
    }

private:
    static std::size_t whole(double place) { return static_cast<std::size_t>(place); }

    int cells_, parts_;
};

/// Returns the share of a part of the picture that is white, in [0, 1]. Samples it at least four times per cell along
/// each axis.
float sampled_white_share(const Ground& ground, const Part& part) {
    constexpr int kSamples = 4;
    const Point size = part.high - part.low;
    const int across = kSamples * static_cast<int>(std::ceil(size.x));
    const int down = kSamples * static_cast<int>(std::ceil(size.y));
    int white = 0;
    for (int y = 0; y < down; ++y) {
        for (int x = 0; x < across; ++x)
            white += ground.is_white(part.low + Point{(x + 0.5) / across * size.x, (y + 0.5) / down * size.y});
    }
    return static_cast<float>(white) / static_cast<float>(across * down);
}

/// Sharpens light by unsharp masking.
std::vector<float> unsharp_masked(const std::vector<float>& light, const CellGrid& cells, double sigma, double strength,
                                  Executor& executor) {
    std::vector<float> result = blurred(light, cells.columns, cells.rows, sigma, executor);
    const auto gain = static_cast<float>(strength);
    for_ranges(executor, light.size(), kPixelsOfTask, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            result[i] = std::clamp(light[i] + gain * (light[i] - result[i]), 0.0f, 1.0f);
    });
    return result;
}

/// Makes nearly grey cells grey, so that the boundaries of all channels coincide there. Moves each channel towards the
/// luminance by at most 0.04 plus 0.75 times the change of the luminance per cell.
void join_greys(std::vector<std::vector<float>>& light, const CellGrid& cells, Executor& executor) {
    constexpr float kNear = 0.04f, kCells = 0.75f;
    const auto columns = static_cast<std::size_t>(cells.columns), rows = static_cast<std::size_t>(cells.rows);
    std::vector<float> grey(light.front().size());
    for_ranges(executor, grey.size(), kPixelsOfTask, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) grey[i] = luminance_of(light[0][i], light[1][i], light[2][i]);
    });
    for_ranges(executor, grey.size(), kPixelsOfTask, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            const std::size_t x = i % columns, y = i / columns;
            const float across = grey[x + 1 < columns ? i + 1 : i] - grey[x > 0 ? i - 1 : i];
            const float down = grey[y + 1 < rows ? i + columns : i] - grey[y > 0 ? i - columns : i];
            const float near = kNear + kCells / 2 * std::sqrt(across * across + down * down);
            for (auto& channel : light) {
                const float off = channel[i] - grey[i];
                channel[i] = grey[i] + std::copysign(std::max(std::abs(off) - near, 0.0f), off);
            }
        }
    });
}

}  // namespace

Ground::Ground(std::vector<float> level, const CellGrid& cells) : cells_(cells), level_(std::move(level)) {
    assert(level_.size() == static_cast<std::size_t>(cells.columns) * static_cast<std::size_t>(cells.rows));
}

bool Ground::is_white(Point place) const {
    return interpolated(level_, cells_.columns, cells_.rows, place) > kBoundary;
}

Ground Ground::inverse() const {
    std::vector<float> level = level_;
    for (float& each : level) each = 2 * kBoundary - each;
    return {std::move(level), cells_};
}

std::vector<float> Ground::white_shares(const CellGrid& parts, Executor& executor) const {
    constexpr std::uint8_t kWhite = 1, kBlack = 2;
    const auto columns = static_cast<std::size_t>(parts.columns), rows = static_cast<std::size_t>(parts.rows);
    const auto width = static_cast<std::size_t>(cells_.columns);
    const CellRanges across(cells_.columns, parts.columns), down(cells_.rows, parts.rows);
    std::vector<float> shares(columns * rows);
    for_ranges(executor, rows, rows_of_task(parts.columns), [&](std::size_t begin, std::size_t end) {
        std::vector<std::uint8_t> grounds(width);  // grounds in each column of cells, as bits
        for (std::size_t row = begin; row < end; ++row) {
            std::ranges::fill(grounds, std::uint8_t{0});
            for (std::size_t y = down.first(row); y < down.end(row); ++y) {
                const float* level = level_.data() + y * width;
                for (std::size_t x = 0; x < width; ++x) grounds[x] |= level[x] > kBoundary ? kWhite : kBlack;
            }
            for (std::size_t column = 0; column < columns; ++column) {
                std::uint8_t all = 0;
                for (std::size_t x = across.first(column); x < across.end(column); ++x) all |= grounds[x];
                float& share = shares[row * columns + column];
                share = all == kWhite ? 1 : 0;
                if (all == (kWhite | kBlack)) {
                    share = sampled_white_share(*this, {{across.begin(column), down.begin(row)},
                                                        {across.begin(column + 1), down.begin(row + 1)}});
                }
            }
        }
    });
    return shares;
}

void Ground::apply(Raster& flipped, Point scale, bool antialias, Executor& executor) const {
    const Point step{1 / scale.x, 1 / scale.y};
    const auto width = static_cast<std::size_t>(flipped.width);
    const PixelColumns columns(flipped.width, step.x, cells_.columns);
    for_ranges(executor, static_cast<std::size_t>(flipped.height), rows_of_task(flipped.width),
               [&](std::size_t begin, std::size_t end) {
                   for (std::size_t y = begin; y < end; ++y) {
                       const LevelRow row(*this, (static_cast<double>(y) + 0.5) * step.y);
                       std::uint8_t* pixels = flipped.coverage.data() + y * width;
                       columns.for_runs([&](std::size_t begin_x, std::size_t end_x, const BetweenPixels& between) {
                           apply_run(row, columns, begin_x, end_x, between, step, antialias, pixels);
                       });
                   }
               });
}

std::vector<Ground> divide_ground(std::span<const std::vector<float>> light, const CellGrid& cells, double radius,
                                  double detail, bool is_rgb, Executor& executor) {
    // Chosen by eye and by lightness errors of eleven photographs and pages of text. With less smoothing, boundaries
    // meander through noise. With more smoothing, strokes of text dissolve into dots.
    constexpr double kSurroundings = 3, kEmphasis = 1.4, kSmoothing = 0.4;
    constexpr float kMinStrength = 1e-3f;  // used if dots are much smaller than cells
    constexpr int kSteps = 15;
    std::vector<std::vector<float>> clear;
    for (const auto& channel : light)
        clear.push_back(unsharp_masked(channel, cells, kSurroundings * radius, kEmphasis * detail, executor));
    if (is_rgb) join_greys(clear, cells, executor);
    const float strength = std::max(static_cast<float>(kSmoothing * radius), kMinStrength);
    std::vector<Ground> grounds;
    for (auto& channel : clear) {
        grounds.emplace_back(denoised(channel, cells.columns, cells.rows, strength, kSteps, executor), cells);
        channel = std::vector<float>();  // frees the memory
    }
    return grounds;
}

}  // namespace ccdt
