#include "core/halftone/separation.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numeric>
#include <optional>

namespace ccdt {

namespace {

using Cover = std::array<float, kMostInks>;

/// Least squares in what the eye tells apart: luminance, and each channel's difference from it, which counts less.
constexpr std::size_t kRows = 4;
using Seen = std::array<double, kRows>;

Seen seen(const Light& light) {
    constexpr double kColour = 0.5;
    const double luminance = 0.2126 * light.red + 0.7152 * light.green + 0.0722 * light.blue;
    return {luminance, kColour * (light.red - luminance), kColour * (light.green - luminance),
            kColour * (light.blue - luminance)};
}

double dot(const Seen& a, const Seen& b) {
    return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

Seen operator-(const Seen& a, const Seen& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2], a[3] - b[3]};
}

Light full_cover(const InkSet& inks, std::size_t ink) {
    std::array<float, kMostInks> cover{};
    cover[ink] = 1;
    return printed(inks, std::span(cover).first(inks.inks.size()));
}

Light mapped(const Light& light, Tone tone) {
    const auto map = [&](float value) { return tone == Tone::Linear ? to_share(value) : lightness(to_share(value)); };
    return {map(light.red), map(light.green), map(light.blue)};
}

using Shares = std::array<double, kMostInks>;

/// Finds the cover of each ink whose print looks most like a colour: least squares, and of equals the least cover.
///
/// A quadratic programme in a box, solved by active sets as in bounded-variable least squares (Stark, Parker 1995).
/// What is minimized is convex, strictly so by a little ridge: the solution is one, and continuous in the colour.
class Mixer {
public:
    Mixer(const InkSet& inks, Tone tone);

    Cover mix(const Light& light) const;

private:
    enum class Place { None, Free, Full };
    using Places = std::array<Place, kMostInks>;

    std::optional<std::size_t> to_free(const Shares& cover, const Places& places, const Shares& wanted) const;
    Shares solve(const Shares& cover, const Places& places, const Shares& wanted) const;
    double step(Shares& cover, Places& places, const Shares& to) const;

    std::size_t count_;
    Seen paper_;
    std::array<Seen, kMostInks> changes_{};     ///< what a full cover changes
    std::array<Shares, kMostInks> products_{};  ///< of changes, and the ridge
};

Mixer::Mixer(const InkSet& inks, Tone tone) : count_(inks.inks.size()), paper_(seen(mapped(inks.paper, tone))) {
    constexpr double kRidge = 1e-7;
    for (std::size_t i = 0; i < count_; ++i) changes_[i] = seen(mapped(full_cover(inks, i), tone)) - paper_;
    for (std::size_t i = 0; i < count_; ++i) {
        for (std::size_t k = 0; k < count_; ++k)
            products_[i][k] = dot(changes_[i], changes_[k]) + (i == k ? kRidge : 0);
    }
}

Cover Mixer::mix(const Light& light) const {
    constexpr double kPriceOfCover = 1e-6;
    constexpr int kMostRounds = 100;  // it needs a few
    const Seen change = seen(light) - paper_;
    Shares wanted{}, cover{};
    for (std::size_t i = 0; i < count_; ++i) wanted[i] = dot(changes_[i], change) - kPriceOfCover;
    Places places{};
    for (int round = 0; round < kMostRounds; ++round) {
        const auto next = to_free(cover, places, wanted);
        if (!next) break;
        places[*next] = Place::Free;
        while (step(cover, places, solve(cover, places, wanted)) < 1) {
        }
    }
    Cover result{};
    std::transform(cover.begin(), cover.end(), result.begin(), [](double c) { return static_cast<float>(c); });
    return result;
}

/// The ink at an end of its range that gains most by leaving it.
std::optional<std::size_t> Mixer::to_free(const Shares& cover, const Places& places, const Shares& wanted) const {
    double most = 1e-12;
    std::optional<std::size_t> found;
    for (std::size_t i = 0; i < count_; ++i) {
        if (places[i] == Place::Free) continue;
        const double slope = wanted[i] - std::inner_product(cover.begin(), cover.end(), products_[i].begin(), 0.0);
        const double gain = places[i] == Place::None ? slope : -slope;
        if (gain <= most) continue;
        most = gain;
        found = i;
    }
    return found;
}

/// The best cover by the free inks, bounds left aside: Gauss elimination, safe without pivots as the matrix is
/// positive.
Shares Mixer::solve(const Shares& cover, const Places& places, const Shares& wanted) const {
    std::array<std::size_t, kMostInks> free{};
    std::size_t n = 0;
    for (std::size_t i = 0; i < count_; ++i) {
        if (places[i] == Place::Free) free[n++] = i;
    }
    std::array<std::array<double, kMostInks + 1>, kMostInks> rows{};
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t k = 0; k < n; ++k) rows[i][k] = products_[free[i]][free[k]];
        rows[i][n] = wanted[free[i]];
        for (std::size_t k = 0; k < count_; ++k) {
            if (places[k] == Place::Full) rows[i][n] -= products_[free[i]][k];
        }
    }
    for (std::size_t pivot = 0; pivot < n; ++pivot) {
        for (std::size_t i = pivot + 1; i < n; ++i) {
            const double factor = rows[i][pivot] / rows[pivot][pivot];
            for (std::size_t k = pivot; k <= n; ++k) rows[i][k] -= factor * rows[pivot][k];
        }
    }
    Shares to = cover;
    for (std::size_t i = n; i-- > 0;) {
        double value = rows[i][n];
        for (std::size_t k = i + 1; k < n; ++k) value -= rows[i][k] * to[free[k]];
        to[free[i]] = value / rows[i][i];
    }
    return to;
}

/// Goes towards a cover as far as all inks stay in range; one that comes to an end of it stays there.
/// @returns  the share of the way
double Mixer::step(Shares& cover, Places& places, const Shares& to) const {
    double share = 1;
    std::size_t first = count_;
    for (std::size_t i = 0; i < count_; ++i) {
        if (places[i] != Place::Free || (to[i] >= 0 && to[i] <= 1)) continue;
        const double reach = ((to[i] < 0 ? 0 : 1) - cover[i]) / (to[i] - cover[i]);
        if (reach >= share) continue;
        share = reach;
        first = i;
    }
    for (std::size_t i = 0; i < count_; ++i) cover[i] += share * (to[i] - cover[i]);
    if (first == count_) return 1;
    places[first] = to[first] < 0 ? Place::None : Place::Full;
    cover[first] = to[first] < 0 ? 0 : 1;
    return share;
}

/// A table over all colours. Between its nodes it is linear in each tetrahedron about the greys, as are inks that
/// stand for the least of a colour's channels.
class MixTable {
public:
    explicit MixTable(const Mixer& mixer) {
        nodes_.reserve(kSide * kSide * kSide);
        for (std::size_t b = 0; b < kSide; ++b) {
            for (std::size_t g = 0; g < kSide; ++g) {
                for (std::size_t r = 0; r < kSide; ++r) nodes_.push_back(mixer.mix({at(r), at(g), at(b)}));
            }
        }
    }

    Cover mix(const Light& light) const {
        struct Axis {
            float part;
            std::size_t step;
        };
        std::size_t node = 0;
        const auto axis = [&](float value, std::size_t step) {
            const float place = value * (kSide - 1);
            const std::size_t below = std::min(static_cast<std::size_t>(place), kSide - 2);
            node += below * step;
            return Axis{place - static_cast<float>(below), step};
        };
        std::array<Axis, 3> axes{axis(light.red, 1), axis(light.green, kSide), axis(light.blue, kSide * kSide)};
        const auto order = [&](Axis& a, Axis& b) {
            if (a.part < b.part) std::swap(a, b);
        };
        order(axes[0], axes[1]);
        order(axes[1], axes[2]);
        order(axes[0], axes[1]);
        Cover cover{};
        const auto add = [&](float weight) {
            for (std::size_t i = 0; i < kMostInks; ++i) cover[i] += weight * nodes_[node][i];
        };
        add(1 - axes[0].part);
        for (std::size_t k = 0; k < 3; ++k) {
            node += axes[k].step;
            add(axes[k].part - (k < 2 ? axes[k + 1].part : 0));
        }
        return cover;
    }

private:
    static constexpr std::size_t kSide = 17;
    static float at(std::size_t index) { return static_cast<float>(index) / (kSide - 1); }

    std::vector<Cover> nodes_;
};

}  // namespace

InkSet cmyk_inks() {
    return {{{0, 1, 1}, {1, 0, 1}, {1, 1, 0}, {0, 0, 0}}, {1, 1, 1}, false};
}

InkSet rgb_inks() {
    return {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, {0, 0, 0}, true};
}

Light printed(const InkSet& inks, std::span<const float> cover) {
    Light light = inks.paper;
    for (std::size_t i = 0; i < inks.inks.size(); ++i) {
        const auto lay = [&](float below, float ink) {
            return inks.additive ? std::min(1.0f, below + cover[i] * ink) : below * (1 - cover[i] * (1 - ink));
        };
        light = {lay(light.red, inks.inks[i].red), lay(light.green, inks.inks[i].green),
                 lay(light.blue, inks.inks[i].blue)};
    }
    return light;
}

std::vector<std::vector<float>> separate(const ColourPicture& picture, const InkSet& inks, Tone tone,
                                         const std::stop_token& stop) {
    assert(!inks.inks.empty() && inks.inks.size() <= kMostInks);
    const std::size_t pixels = picture.red.size();
    std::vector<std::vector<float>> coverage(inks.inks.size(), std::vector<float>(pixels));
    const MixTable table(Mixer(inks, tone));
    for (std::size_t p = 0; p < pixels; ++p) {
        if (p % static_cast<std::size_t>(picture.width) == 0 && stop.stop_requested()) break;
        const float alpha = picture.alpha.empty() ? 1 : to_share(picture.alpha[p]);
        const Cover cover = table.mix(mapped({picture.red[p], picture.green[p], picture.blue[p]}, tone));
        for (std::size_t i = 0; i < coverage.size(); ++i) coverage[i][p] = alpha * cover[i];
    }
    return coverage;
}

std::vector<std::size_t> share_sites(std::span<const double> ink_sums, std::size_t sites) {
    const double total = std::accumulate(ink_sums.begin(), ink_sums.end(), 0.0);
    std::vector<std::size_t> shares(ink_sums.size(), 0);
    if (!(total > 0)) return shares;
    std::vector<std::size_t> order(ink_sums.size());
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) { return ink_sums[a] > ink_sums[b]; });
    std::size_t left = sites;
    for (const std::size_t ink : order) {
        if (left == 0 || !(ink_sums[ink] > 0)) break;
        shares[ink] = 1;
        --left;
    }
    // The largest quotient of sum and share takes the next one; what is far below its part is filled at once.
    const auto quota = [&](std::size_t ink) { return ink_sums[ink] / total * static_cast<double>(sites); };
    for (const std::size_t ink : order) {
        const auto whole = static_cast<std::size_t>(quota(ink));
        const std::size_t more = std::min(left, whole > shares[ink] ? whole - shares[ink] : 0);
        shares[ink] += more;
        left -= more;
    }
    for (; left > 0; --left) {
        const auto missing = [&](std::size_t ink) { return quota(ink) - static_cast<double>(shares[ink]); };
        const std::size_t most = *std::ranges::max_element(order, {}, missing);
        ++shares[most];
    }
    return shares;
}

}  // namespace ccdt
