// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/polish/stealth.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <type_traits>

namespace ccdt {

namespace {

constexpr double kTau = 2 * std::numbers::pi;
constexpr double kCells = 5;    ///< cells of the grid per cycle of the highest frequency; see SplineKernel
constexpr double kMinRows = 4;  ///< least width of a torus, in spacings
/// Conjugate gradients of a round end once the remainder of F (see Stealth) is this small, relative to F. The next
/// round, a step of Newton's method, squares the remainder.
constexpr double kMaxRemainder = 0.01;
constexpr int kMaxSteps = 40;
constexpr std::size_t kSites = 8192;  ///< sites per task

/// Returns the lowest frequency whose power is not removed, in cycles per unit.
double end_of(const Domain& torus, std::size_t sites) {
    return Stealth::kLimit * std::sqrt(static_cast<double>(sites) / torus.unit_area());
}

int highest(double end, double side) {
    return static_cast<int>(std::ceil(end * side)) - 1;
}

int cells_for(double end, double side) {
    return good_size(std::max(kCells * end * side, 8.0));
}

}  // namespace

double Stealth::fewest_sites(Point sides) {
    return kMinRows * kMinRows * (std::max(sides.x, sides.y) / std::min(sides.x, sides.y));
}

bool Stealth::fits(const Domain& torus, std::size_t sites) {
    constexpr double kRounding = 1e-9;
    return static_cast<double>(sites) >= (1 - kRounding) * fewest_sites(torus.unit_bounds().max);
}

Stealth::Stealth(const Domain& torus, std::size_t sites, Executor& executor)
    : executor_(executor),
      sides_(torus.unit_bounds().max),
      sites_(static_cast<double>(sites)),
      transform_(highest(end_of(torus, sites), sides_.x), highest(end_of(torus, sites), sides_.y)),
      positions_(sites),
      grid_(true, sides_, {cells_for(end_of(torus, sites), sides_.x), cells_for(end_of(torus, sites), sides_.y), 1},
            executor) {
    const double end = end_of(torus, sites);
    const int columns = highest(end, sides_.x), rows = highest(end, sides_.y);
    for (int row = -rows; row <= rows; ++row) {
        for (int column = 0; column <= columns; ++column) {
            if (column == 0 && row <= 0) continue;
            const Point f = grid_.frequency({column, row, 0});
            const double squared = dot(f, f);
            if (squared < end * end) waves_.push_back({column, row, sites_ * kTau * kTau * squared});
        }
    }
    sums_.resize(waves_.size());
}

bool Stealth::displacements(std::span<const Point> sites, std::span<Point> moves, const std::stop_token& stop) {
    if (!measure(sites, stop) || largest_power_ < kNegligiblePower) return false;
    Coefficients left(waves_.size()), eased(waves_.size()), changed(waves_.size()), potential(waves_.size());
    std::ranges::transform(sums_, left.begin(), [](const auto& sum) { return -sum; });
    precondition(left, eased);
    Coefficients step = eased;
    double size = product(left, eased);
    const double enough = kMaxRemainder * kMaxRemainder * size;
    for (int steps = 0; steps < kMaxSteps && size > enough; ++steps) {
        if (stop.stop_requested()) return false;
        find_moves(step, sites, moves);
        change_of(sites, moves, changed);
        const double curvature = product(step, changed);
        if (!(curvature > 0)) break;
        const double length = size / curvature;
        for (std::size_t k = 0; k < waves_.size(); ++k) {
            potential[k] += length * step[k];
            left[k] -= length * changed[k];
        }
        precondition(left, eased);
        const double next = product(left, eased), share = next / size;
        for (std::size_t k = 0; k < waves_.size(); ++k) step[k] = eased[k] + share * step[k];
        size = next;
    }
    find_moves(potential, sites, moves);
    return true;
}

/// Computes F and its largest power. Returns false after a stop.
bool Stealth::measure(std::span<const Point> sites, const std::stop_token& stop) {
    const auto share = [](double position, double side) {
        const double periods = position / side;
        return std::clamp(periods - std::floor(periods), 0.0, 1.0);
    };
    std::ranges::transform(sites, positions_.begin(), [&](Point p) {
        return WeightedPoint{{share(p.x, sides_.x), share(p.y, sides_.y)}, 1};
    });
    transform_.run(positions_, stop);
    if (stop.stop_requested()) return false;
    largest_power_ = 0;
    for (std::size_t k = 0; k < waves_.size(); ++k) {
        sums_[k] = transform_.value(waves_[k].column, waves_[k].row);
        largest_power_ = std::max(largest_power_, std::norm(sums_[k]) / sites_);
    }
    return true;
}

/// Computes J* p, the gradient of a potential at the sites.
void Stealth::find_moves(const Coefficients& potential, std::span<const Point> sites, std::span<Point> moves) {
    grid_.with_coefficients([&](auto spectrum) {
        if constexpr (std::is_same_v<typename decltype(spectrum)::value_type, std::complex<double>>) {
            std::ranges::fill(spectrum, std::complex<double>());
            for (std::size_t k = 0; k < waves_.size(); ++k) {
                const auto [column, row, diagonal] = waves_[k];
                const auto value = potential[k] / grid_.window({column, row, 0});
                spectrum[grid_.number({column, row, 0})] = value;
                if (column == 0) spectrum[grid_.number({0, -row, 0})] = std::conj(value);
            }
        }
    });
    grid_.transform_back();
    for_ranges(executor_, sites.size(), kSites, [&](std::size_t begin, std::size_t end) {
        grid_.gradients(sites.subspan(begin, end - begin), moves.subspan(begin, end - begin));
    });
}

/// Computes J u, the change of F caused by moves.
void Stealth::change_of(std::span<const Point> sites, std::span<const Point> moves, Coefficients& change) {
    grid_.clear();
    grid_.spread_moves(sites, moves);
    grid_.transform();
    grid_.with_coefficients([&](auto spectrum) {
        if constexpr (std::is_same_v<typename decltype(spectrum)::value_type, std::complex<double>>) {
            for (std::size_t k = 0; k < waves_.size(); ++k) {
                const auto [column, row, diagonal] = waves_[k];
                change[k] = spectrum[grid_.number({column, row, 0})] / grid_.window({column, row, 0});
            }
        }
    });
}

/// Returns the inner product over all waves, both k and -k.
double Stealth::product(const Coefficients& a, const Coefficients& b) const {
    double sum = 0;
    for (std::size_t k = 0; k < waves_.size(); ++k) sum += 2 * (a[k].real() * b[k].real() + a[k].imag() * b[k].imag());
    return sum;
}

void Stealth::precondition(const Coefficients& from, Coefficients& to) const {
    for (std::size_t k = 0; k < waves_.size(); ++k) to[k] = from[k] / waves_[k].diagonal;
}

}  // namespace ccdt
