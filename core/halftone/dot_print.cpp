// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/dot_print.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/halftone/bilinear.h"

namespace ccdt {

namespace {

constexpr double kPi = std::numbers::pi;

double radius(float area) {
    return std::sqrt(static_cast<double>(area) / kPi);
}

}  // namespace

double common_area(double first, double second, double distance) {
    if (distance >= first + second) return 0;
    const double less = std::min(first, second);
    if (distance <= std::abs(first - second)) return kPi * less * less;
    const auto segment = [&](double own, double other) {
        const double cosine = (distance * distance + own * own - other * other) / (2 * distance * own);
        const double angle = std::acos(std::clamp(cosine, -1.0, 1.0));
        return own * own * (angle - std::sin(angle) * std::cos(angle));
    };
    return segment(first, second) + segment(second, first);
}

Point middle_of_overlap(Point one, double first, Point other, double second) {
    const Point way = other - one;
    const double distance = std::sqrt(dot(way, way));
    const double middle = distance > 0 ? (distance + first - second) / 2 / distance : 0.5;
    return one + std::clamp(middle, 0.0, 1.0) * way;
}

void add_light(const CellGrid& cells, Point place, float amount, std::vector<float>& image) {
    const BetweenPixels x(place.x, cells.columns), y(place.y, cells.rows);
    const auto columns = static_cast<std::size_t>(cells.columns);
    float *upper = image.data() + y.first * columns, *lower = image.data() + y.second * columns;
    const float below = amount * y.share, above = amount - below;
    upper[x.first] += above * (1 - x.share);
    upper[x.second] += above * x.share;
    lower[x.first] += below * (1 - x.share);
    lower[x.second] += below * x.share;
}

std::vector<std::array<std::uint32_t, 2>> close_pairs(const CellGrid& cells, std::span<const Point> sites,
                                                      std::span<const float> areas) {
    std::vector<std::array<std::uint32_t, 2>> close;
    constexpr double kMargin = 1.15;  // factor on the distance; keeps pairs complete if areas change a little
    const double widest = radius(*std::ranges::max_element(areas));
    const double side = std::max(2 * kMargin * widest, 1.0);
    const auto columns = static_cast<std::size_t>(cells.columns / side) + 1;
    const auto rows = static_cast<std::size_t>(cells.rows / side) + 1;
    std::vector<std::vector<std::uint32_t>> boxes(columns * rows);
    const auto box_of = [&](Point site) {
        const auto place = [side](double at, std::size_t count) {
            return std::min(static_cast<std::size_t>(std::max(at, 0.0) / side), count - 1);
        };
        return std::pair(place(site.x, columns), place(site.y, rows));
    };
    for (std::uint32_t dot = 0; dot < sites.size(); ++dot) {
        const auto [column, row] = box_of(sites[dot]);
        const double own = radius(areas[dot]);
        for (std::size_t y = row - std::min<std::size_t>(row, 1); y <= std::min(row + 1, rows - 1); ++y) {
            for (std::size_t x = column - std::min<std::size_t>(column, 1); x <= std::min(column + 1, columns - 1);
                 ++x) {
                for (const std::uint32_t other : boxes[y * columns + x]) {
                    const Point way = sites[dot] - sites[other];
                    const double reach = kMargin * (own + radius(areas[other]));
                    if (::ccdt::dot(way, way) < reach * reach) close.push_back({other, dot});
                }
            }
        }
        boxes[row * columns + column].push_back(dot);
    }
    return close;
}

const std::array<Point, kSamplesOfRim>& rim_samples() {
    static const auto ways = [] {
        std::array<Point, kSamplesOfRim> result;
        for (int k = 0; k < kSamplesOfRim; ++k) {
            const double angle = 2 * kPi * k / kSamplesOfRim;
            result[static_cast<std::size_t>(k)] = {std::cos(angle), std::sin(angle)};
        }
        return result;
    }();
    return ways;
}

const std::array<Point, kSamplesOfDisc>& disc_samples() {
    static const auto places = [] {
        constexpr double kGoldenAngle = 2.399963229728653;
        std::array<Point, kSamplesOfDisc> result;
        for (int k = 0; k < kSamplesOfDisc; ++k) {
            const double distance = std::sqrt((k + 0.5) / kSamplesOfDisc), angle = kGoldenAngle * k;
            result[static_cast<std::size_t>(k)] = {distance * std::cos(angle), distance * std::sin(angle)};
        }
        return result;
    }();
    return places;
}

}  // namespace ccdt
