// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/inks/print_proof.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/base/elementary.h"
#include "core/picture/blur.h"
#include "core/picture/colour_difference.h"
#include "core/picture/srgb.h"

namespace ccdt {

namespace {

using Channels = Overprint::Channels;

/// Number of samples per radius, unless kSamplesPerDot permits fewer. With 2.5, gaps in nearly solid areas are missed,
/// and errors in shadows are two thirds larger.
constexpr double kFine = 4;
constexpr double kCoarse = 2;           // least number of samples per radius; if fewer are permitted, no dot moves
constexpr int kCell = 10;               // samples along each side of a cell
constexpr double kSamplesPerDot = 200;  // maximum number of samples, divided by the number of dots

constexpr std::size_t kCellsOfTask = 256;
constexpr std::size_t kSitesOfTask = 1024;

/// Returns the derivative of half the squared colour difference with respect to the light of each channel, scaled for a
/// step of steepest descent. The derivative is divided by the sum of the squared derivatives of the colour difference,
/// and by the wanted luminance. So steps have similar lengths in light and in dark areas.
Channels gradient(const Channels& wanted, const Channels& seen) {
    constexpr double kMinLight = 0.01;
    const ColourDifference difference(lab_of(wanted));
    const Lab off = difference(lab_of(seen));
    Channels gradient{};
    double squares = 0;
    for (std::size_t c = 0; c < 3; ++c) {
        const double step = 0.02 * wanted[c] + 0.002;
        Channels more = seen;
        more[c] += step;
        Lab slope = difference(lab_of(more));
        for (std::size_t k = 0; k < 3; ++k) slope[k] = (slope[k] - off[k]) / step;
        gradient[c] = dot(slope, off);
        squares += dot(slope, slope);
    }
    const double level = luminance_of(wanted[0], wanted[1], wanted[2]);
    for (double& each : gradient) each /= squares * (level + kMinLight);
    return gradient;
}

Channels at(const LightPlanes& planes, std::size_t number) {
    return {planes[0][number], planes[1][number], planes[2][number]};
}

}  // namespace

PrintProof::PrintProof(const LightPlanes& light, const CellGrid& cells, int width, int height, const InkSet& inks,
                       double radius, std::size_t sites, Executor& executor)
    : radius_(radius),
      step_(std::max(radius / kFine,
                     std::sqrt(static_cast<double>(width) * height /
                               (kSamplesPerDot * static_cast<double>(std::max<std::size_t>(sites, 1)))))) {
    if (step_ > radius / kCoarse) return;
    width_ = std::max(1, static_cast<int>(width / step_));
    height_ = std::max(1, static_cast<int>(height / step_));
    columns_ = (width_ + kCell - 1) / kCell;
    rows_ = (height_ + kCell - 1) / kCell;
    for (std::size_t i = 0; i < directions_.size(); ++i) {
        const double angle = 2 * std::numbers::pi * static_cast<double>(i) / static_cast<double>(directions_.size());
        directions_[i] = {elementary::cos(angle), elementary::sin(angle)};
    }
    for (std::size_t bits = 0; bits < std::size_t{1} << inks.inks.size(); ++bits) {
        std::vector<float> cover;
        for (std::size_t i = 0; i < inks.inks.size(); ++i) cover.push_back(static_cast<float>(bits >> i & 1));
        const Light colour = printed(inks, cover);
        colours_.push_back({colour.red, colour.green, colour.blue});
    }
    wanted_ = means(
        [&](int x, int y) {
            const auto cell = [&](int sample, int count, int size) {
                const double position = (sample + 0.5) * step_ * (static_cast<double>(count) / size);
                return static_cast<std::size_t>(std::min(static_cast<int>(position), count - 1));
            };
            return at(light, cell(y, cells.rows, height) * static_cast<std::size_t>(cells.columns) +
                                 cell(x, cells.columns, width));
        },
        executor);
}

/// Returns the mean light of the samples in each cell, blurred with a standard deviation of one cell.
template <class LightAt>
LightPlanes PrintProof::means(const LightAt& light_at, Executor& executor) const {
    LightPlanes means;
    const std::size_t cells = static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_);
    for (auto& plane : means) plane.resize(cells);
    for_ranges(executor, cells, kCellsOfTask, [&](std::size_t begin, std::size_t end) {
        for (std::size_t cell = begin; cell < end; ++cell) {
            const auto columns = static_cast<std::size_t>(columns_);
            const Channels light = mean(light_at, static_cast<int>(cell % columns), static_cast<int>(cell / columns));
            for (std::size_t c = 0; c < 3; ++c) means[c][cell] = static_cast<float>(light[c]);
        }
    });
    for (auto& plane : means) plane = blurred(std::move(plane), columns_, rows_, 1, executor);
    return means;
}

/// Returns the mean light of the samples in a cell.
template <class LightAt>
PrintProof::Channels PrintProof::mean(const LightAt& light_at, int column, int row) const {
    const int right = std::min(width_, (column + 1) * kCell), below = std::min(height_, (row + 1) * kCell);
    Channels mean{};
    for (int y = row * kCell; y < below; ++y) {
        for (int x = column * kCell; x < right; ++x) {
            const Channels light = light_at(x, y);
            for (std::size_t c = 0; c < 3; ++c) mean[c] += light[c];
        }
    }
    const double count = (right - column * kCell) * (below - row * kCell);
    for (double& each : mean) each /= count;
    return mean;
}

/// Returns the inks that cover the centre of each sample, as a set of bits.
std::vector<std::uint8_t> PrintProof::printed_samples(std::span<const std::vector<Point>> sites,
                                                      const std::stop_token& stop, Executor& executor) const {
    std::vector<std::uint8_t> samples(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
    const double reach = radius_ / step_;
    const auto first = [](double from, int least, int most) {
        return static_cast<int>(std::clamp<double>(std::ceil(from), least, most));
    };
    // Each task draws one band of rows and visits all sites.
    constexpr std::size_t kBands = 16;
    for_ranges(executor, static_cast<std::size_t>(height_), (static_cast<std::size_t>(height_) + kBands - 1) / kBands,
               [&](std::size_t begin, std::size_t end) {
                   const int top = static_cast<int>(begin), bottom = static_cast<int>(end);
                   for (std::size_t ink = 0; ink < sites.size() && !stop.stop_requested(); ++ink) {
                       for (const Point& site : sites[ink]) {
                           const Point centre = 1 / step_ * site - Point{0.5, 0.5};
                           const int below = first(centre.y + reach, top, bottom);
                           for (int y = first(centre.y - reach, top, bottom); y < below; ++y) {
                               const double dy = y - centre.y, half = std::sqrt(std::max(0.0, reach * reach - dy * dy));
                               const auto row = samples.begin() + static_cast<std::ptrdiff_t>(y) * width_;
                               const int right = first(centre.x + half, 0, width_);
                               for (int x = first(centre.x - half, 0, width_); x < right; ++x)
                                   row[x] = static_cast<std::uint8_t>(row[x] | 1U << ink);
                           }
                       }
                   }
               });
    return samples;
}

/// Returns the result of gradient() for each cell.
LightPlanes PrintProof::gradients(const std::vector<std::uint8_t>& samples, Executor& executor) const {
    const LightPlanes seen = means(
        [&](int x, int y) {
            return colours_[samples[static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) +
                                    static_cast<std::size_t>(x)]];
        },
        executor);
    LightPlanes gradients = seen;
    for_ranges(executor, seen[0].size(), kCellsOfTask, [&](std::size_t begin, std::size_t end) {
        for (std::size_t cell = begin; cell < end; ++cell) {
            const Channels here = gradient(at(wanted_, cell), at(seen, cell));
            for (std::size_t c = 0; c < 3; ++c) gradients[c][cell] = static_cast<float>(here[c]);
        }
    });
    return gradients;
}

/// Returns the move of a dot. Samples just outside the rim attract the dot if it would decrease the colour difference
/// by covering them. Otherwise they repel the dot.
Point PrintProof::move(Point site, unsigned ink, const std::vector<std::uint8_t>& samples,
                       const LightPlanes& gradients) const {
    constexpr double kStrength = 0.2;  // radii per unit of the slope
    constexpr double kLongest = 0.15;  // largest length of a move, radii
    constexpr double kOutside = 0.7;   // distance from the rim in samples, at which the dot covers no sample
    const double reach = radius_ / step_ + kOutside;
    const Point centre = 1 / step_ * site;
    const auto cell = [](double position, int size) {
        return static_cast<std::size_t>(std::clamp(static_cast<int>(position / kCell), 0, size - 1));
    };
    const Channels gradient =
        at(gradients, cell(centre.y, rows_) * static_cast<std::size_t>(columns_) + cell(centre.x, columns_));
    Point slope{};
    for (const Point& direction : directions_) {
        const Point rim = centre + reach * direction;
        if (!(rim.x >= 0 && rim.x < width_ && rim.y >= 0 && rim.y < height_)) continue;
        const unsigned there = samples[static_cast<std::size_t>(rim.y) * static_cast<std::size_t>(width_) +
                                       static_cast<std::size_t>(rim.x)];
        if ((there >> ink & 1U) != 0) continue;
        double cost = 0;
        for (std::size_t c = 0; c < 3; ++c) cost += gradient[c] * (colours_[there | 1U << ink][c] - colours_[there][c]);
        slope = slope + cost * direction;
    }
    const double length = kStrength * std::sqrt(dot(slope, slope));
    return -radius_ * kStrength * std::min(1.0, length > kLongest ? kLongest / length : 1.0) * slope;
}

std::vector<std::vector<Point>> PrintProof::moves(std::span<const std::vector<Point>> sites,
                                                  const std::stop_token& stop, Executor& executor) const {
    std::vector<std::vector<Point>> moves;
    for (const auto& each : sites) moves.emplace_back(each.size());
    if (columns_ == 0) return moves;
    const auto samples = printed_samples(sites, stop, executor);
    const LightPlanes gradients = this->gradients(samples, executor);
    for (unsigned ink = 0; ink < sites.size(); ++ink) {
        if (stop.stop_requested()) break;
        for_ranges(executor, sites[ink].size(), kSitesOfTask, [&](std::size_t begin, std::size_t end) {
            for (std::size_t site = begin; site < end; ++site)
                moves[ink][site] = move(sites[ink][site], ink, samples, gradients);
        });
    }
    return moves;
}

}  // namespace ccdt
