// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/kind_mixture.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/halftone/colour_difference.h"

namespace ccdt {

namespace {

constexpr std::size_t kRows = 4;  ///< errors of lightness, chroma, hue, and of the sum of the shares
using Row = std::array<double, kRows>;

double product(const Row& a, const Row& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
}

/// Minimizes |A x - wanted|^2 / 2 + prices x + kRidge |x|^2 / 2 for x >= 0, where `columns` are the columns of A.
///
/// Uses the active-set method of Lawson and Hanson (1974). The result is sparse: it has about as many positive entries
/// as A has rows.
class SparseLeastSquares {
public:
    SparseLeastSquares(std::span<const Row> columns, const Row& wanted, std::span<const double> prices)
        : columns_(columns), wanted_(wanted), prices_(prices), x_(columns.size(), 0) {}

    const std::vector<double>& minimize() {
        constexpr int kMaxSteps = 100;
        for (int step = 0; step < kMaxSteps && free_.size() < kMaxFree && free_variable(); ++step) {
            while (!move_to_minimum()) {
            }
        }
        return x_;
    }

private:
    static constexpr double kRidge = 1e-2, kNothing = 1e-9;
    static constexpr std::size_t kMaxFree = 12;

    /// Releases, among the variables held at 0, the one whose release decreases the objective fastest.
    /// @returns  false if no release decreases the objective
    bool free_variable() {
        Row off = wanted_;
        for (const std::size_t k : free_) {
            for (std::size_t r = 0; r < kRows; ++r) off[r] -= x_[k] * columns_[k][r];
        }
        double most = 1e-6;
        std::size_t best = columns_.size();
        for (std::size_t k = 0; k < columns_.size(); ++k) {
            const double gain = product(columns_[k], off) - prices_[k];
            if (gain > most && std::ranges::find(free_, k) == free_.end()) {
                most = gain;
                best = k;
            }
        }
        if (best == columns_.size()) return false;
        free_.push_back(best);
        return true;
    }

    /// Moves the free variables towards the minimum of the objective. If a variable becomes 0 first, holds it at 0.
    /// @returns  whether the minimum was reached
    bool move_to_minimum() {
        const std::vector<double> to = minimum();
        double share = 1;
        for (std::size_t i = 0; i < free_.size(); ++i) {
            const double from = x_[free_[i]];
            if (to[i] < kNothing) share = std::min(share, from > 0 ? from / (from - to[i]) : 0.0);
        }
        for (std::size_t i = 0; i < free_.size(); ++i) {
            double& x = x_[free_[i]];
            x = share == 1 ? to[i] : x + share * (to[i] - x);
        }
        if (share == 1) return true;
        for (const std::size_t k : free_) {
            if (x_[k] < kNothing) x_[k] = 0;
        }
        std::erase_if(free_, [&](std::size_t k) { return x_[k] == 0; });
        return free_.empty();
    }

    /// Returns the free variables at the minimum without the constraint x >= 0, by Cholesky's method.
    std::vector<double> minimum() const {
        const std::size_t n = free_.size();
        std::array<std::array<double, kMaxFree>, kMaxFree> a{};
        std::vector<double> b(n);
        for (std::size_t j = 0; j < n; ++j) {
            b[j] = product(columns_[free_[j]], wanted_) - prices_[free_[j]];
            for (std::size_t i = j; i < n; ++i) a[i][j] = product(columns_[free_[i]], columns_[free_[j]]);
            a[j][j] += kRidge;
        }
        for (std::size_t j = 0; j < n; ++j) {
            for (std::size_t k = 0; k < j; ++k) a[j][j] -= a[j][k] * a[j][k];
            a[j][j] = std::sqrt(std::max(a[j][j], kRidge / 2));
            for (std::size_t i = j + 1; i < n; ++i) {
                for (std::size_t k = 0; k < j; ++k) a[i][j] -= a[i][k] * a[j][k];
                a[i][j] /= a[j][j];
            }
            for (std::size_t k = 0; k < j; ++k) b[j] -= a[j][k] * b[k];
            b[j] /= a[j][j];
        }
        for (std::size_t j = n; j-- > 0;) {
            for (std::size_t k = j + 1; k < n; ++k) b[j] -= a[k][j] * b[k];
            b[j] /= a[j][j];
        }
        return b;
    }

    std::span<const Row> columns_;
    const Row wanted_;
    std::span<const double> prices_;
    std::vector<double> x_;
    std::vector<std::size_t> free_;
};

}  // namespace

KindMixture::KindMixture(const InkSet& inks, std::vector<unsigned> kinds)
    : kinds_(std::move(kinds)), tables_(std::size_t{1} << inks.inks.size()), is_made_(tables_.size()) {
    for (std::size_t there = 0; there < tables_.size(); ++there) {
        std::vector<float> cover;
        for (std::size_t ink = 0; ink < inks.inks.size(); ++ink) cover.push_back(static_cast<float>(there >> ink & 1));
        colours_.push_back(Overprint::channels_of(printed(inks, cover)));
    }
}

KindMixture::Shares KindMixture::shares(unsigned ground, const Light& wanted) {
    std::call_once(is_made_[ground], [&] {
        tables_[ground] = std::make_unique<ColourTable<Shares>>(
            [this, ground](const Light& light) { return solve(ground, light); }, Steps::Light, kinds_.size());
    });
    return (*tables_[ground])(wanted);
}

KindMixture::Channels KindMixture::light(unsigned ground, const Shares& shares) const {
    Channels light{};
    for (std::size_t c = 0; c < light.size(); ++c) {
        light[c] = static_cast<float>(colours_[ground][c]);
        for (std::size_t k = 0; k < kinds_.size(); ++k)
            light[c] += shares[k] * static_cast<float>(colours_[ground ^ kinds_[k]][c] - colours_[ground][c]);
    }
    return light;
}

KindMixture::Channels KindMixture::change(unsigned ground, std::size_t kind) const {
    Channels change{};
    for (std::size_t c = 0; c < change.size(); ++c)
        change[c] = static_cast<float>(colours_[ground ^ kinds_[kind]][c] - colours_[ground][c]);
    return change;
}

KindMixture::Shares KindMixture::solve(unsigned ground, const Light& wanted) const {
    // Penalties for full coverage by a kind, in squared colour differences: kPrice for any kind, plus kPriceOfContrast
    // times the colour difference between dots and ground.
    constexpr double kPrice = 0.05, kPriceOfContrast = 0.005, kSum = 1000, kStep = 1e-3, kExact = 1e-4;
    constexpr int kMaxSteps = 12, kMaxHalvings = 6;
    const std::size_t kinds = kinds_.size();
    const ColourDifference difference(lab_of(Overprint::channels_of(wanted)));
    const Lab bare = lab_of(colours_[ground]);
    std::vector<double> prices(kinds + 1, 0), shares(kinds, 0);
    for (std::size_t k = 0; k < kinds; ++k) {
        const Lab full = lab_of(colours_[ground ^ kinds_[k]]);
        const Lab way{full[0] - bare[0], full[1] - bare[1], full[2] - bare[2]};
        prices[k] = kPrice + kPriceOfContrast * std::sqrt(dot(way, way));
    }
    const auto seen = [&](const std::vector<double>& mixed) {
        Overprint::Channels light = colours_[ground];
        for (std::size_t k = 0; k < kinds; ++k) {
            for (std::size_t c = 0; c < 3; ++c)
                light[c] += mixed[k] * (colours_[ground ^ kinds_[k]][c] - colours_[ground][c]);
        }
        return light;
    };
    const auto cost = [&](const std::vector<double>& mixed) {
        const Lab off = difference(lab_of(seen(mixed)));
        double sum = dot(off, off) / 2;
        for (std::size_t k = 0; k < kinds; ++k) sum += prices[k] * mixed[k];
        return sum;
    };
    double best = cost(shares);
    std::vector<Row> columns(kinds + 1, Row{});
    for (int step = 0; step < kMaxSteps; ++step) {
        const Overprint::Channels light = seen(shares);
        const Lab off = difference(lab_of(light));
        std::array<Lab, 3> slopes{};
        for (std::size_t c = 0; c < 3; ++c) {
            Overprint::Channels next = light;
            const double way = next[c] < 0.5 ? kStep : -kStep;
            next[c] += way;
            const Lab there = difference(lab_of(next));
            for (std::size_t r = 0; r < 3; ++r) slopes[c][r] = (there[r] - off[r]) / way;
        }
        Row aim{-off[0], -off[1], -off[2], kSum * kMaxCover};
        for (std::size_t k = 0; k < kinds; ++k) {
            for (std::size_t r = 0; r < 3; ++r) {
                columns[k][r] = 0;
                for (std::size_t c = 0; c < 3; ++c)
                    columns[k][r] += slopes[c][r] * (colours_[ground ^ kinds_[k]][c] - colours_[ground][c]);
                aim[r] += shares[k] * columns[k][r];
            }
            columns[k][3] = kSum;
        }
        columns[kinds] = {0, 0, 0, kSum};  // slack variable of the limit on the sum
        const std::vector<double> to = SparseLeastSquares(columns, aim, prices).minimize();
        double gain = 0, share = 1;
        for (int halving = 0; halving < kMaxHalvings && !(gain > 0); ++halving, share /= 2) {
            std::vector<double> between(kinds);
            for (std::size_t k = 0; k < kinds; ++k) between[k] = std::lerp(shares[k], to[k], share);
            const double there = cost(between);
            gain = best - there;
            if (gain > 0) {
                best = there;
                shares = std::move(between);
            }
        }
        if (!(gain > kExact)) break;
    }
    Shares result{};
    std::ranges::transform(shares, result.begin(), [](double each) { return static_cast<float>(each); });
    return result;
}

}  // namespace ccdt
