#include "core/halftone/separation.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numeric>
#include <optional>

#include "core/halftone/bounded_least_squares.h"

namespace ccdt {

namespace {

using Cover = std::array<float, kMostInks>;
using Numbers = BoundedLeastSquares::Numbers;
static_assert(kMostInks <= BoundedLeastSquares::kMostNumbers);

/// Red, green, blue.
using Channels = std::array<double, 3>;

Channels channels(const Light& light) {
    return {light.red, light.green, light.blue};
}

Light mapped(const Light& light, Tone tone) {
    const auto map = [&](float value) {
        return tone == Tone::Perceptual ? lightness(to_share(value)) : to_share(value);
    };
    return {map(light.red), map(light.green), map(light.blue)};
}

/// The mean light of halftones, by the share that each ink covers.
///
/// Where there is room, dots of different inks lie side by side, and what each takes from the light adds up; where
/// there is none they overlap as if they knew nothing of each other, and what each lets through multiplies (Demichel,
/// Neugebauer). Two inks overlap by their product times T^4 / (T^4 + 0.8), T being the sum of all shares:
/// Halftoned.IsWhatDotsShow compares the light with that of dots on flat tints.
class NeugebauerModel {
public:
    NeugebauerModel(const InkSet& inks, Tone tone);

    std::size_t count() const { return count_; }
    Channels light(const Numbers& cover) const;
    /// Derivative of the light by an ink's cover.
    Channels change(const Numbers& cover, std::size_t ink) const;

private:
    static constexpr double kCrowding = 0.8;

    static double overlap(double sum) { return std::pow(sum, 4) / (std::pow(sum, 4) + kCrowding); }
    /// Share of the light that inks let through on top of each other, one of them left out.
    double through(const Numbers& cover, std::size_t channel, std::size_t but) const;
    /// Light that inks on top of each other leave over what they leave side by side.
    double spared(const Numbers& cover, std::size_t channel) const;

    std::size_t count_;
    bool additive_;
    Channels paper_;
    std::array<Channels, kMostInks> changes_{};  ///< of the paper's light by a full cover
};

NeugebauerModel::NeugebauerModel(const InkSet& inks, Tone tone)
    : count_(inks.inks.size()), additive_(inks.additive), paper_(channels(mapped(inks.paper, tone))) {
    for (std::size_t i = 0; i < count_; ++i) {
        Cover cover{};
        cover[i] = 1;
        const Channels full = channels(mapped(printed(inks, std::span(cover).first(count_)), tone));
        for (std::size_t c = 0; c < 3; ++c) changes_[i][c] = full[c] - paper_[c];
    }
}

double NeugebauerModel::through(const Numbers& cover, std::size_t channel, std::size_t but) const {
    double share = 1;
    for (std::size_t i = 0; i < count_; ++i) {
        if (i != but && paper_[channel] > 0) share *= 1 + cover[i] * changes_[i][channel] / paper_[channel];
    }
    return share;
}

double NeugebauerModel::spared(const Numbers& cover, std::size_t channel) const {
    double beside = paper_[channel];
    for (std::size_t i = 0; i < count_; ++i) beside += cover[i] * changes_[i][channel];
    return paper_[channel] * through(cover, channel, kMostInks) - beside;
}

Channels NeugebauerModel::light(const Numbers& cover) const {
    Channels light = paper_;
    const double overlap = this->overlap(std::accumulate(cover.begin(), cover.end(), 0.0));
    for (std::size_t c = 0; c < 3; ++c) {
        for (std::size_t i = 0; i < count_; ++i) light[c] += cover[i] * changes_[i][c];
        if (!additive_) light[c] += overlap * spared(cover, c);
    }
    return light;
}

Channels NeugebauerModel::change(const Numbers& cover, std::size_t ink) const {
    Channels change = changes_[ink];
    if (additive_) return change;
    const double sum = std::accumulate(cover.begin(), cover.end(), 0.0);
    const double overlap = this->overlap(sum);
    const double steepness = 4 * kCrowding * std::pow(sum, 3) / std::pow(std::pow(sum, 4) + kCrowding, 2);
    for (std::size_t c = 0; c < 3; ++c) {
        change[c] += overlap * changes_[ink][c] * (through(cover, c, ink) - 1) + steepness * spared(cover, c);
    }
    return change;
}

/// Terms in which picture and print are compared: luminance, and each channel's difference from it, which counts less.
/// So a neutral ink alone reproduces luminance, whatever the colour.
using Appearance = std::array<double, 4>;

Appearance appearance(const Channels& light) {
    constexpr double kColour = 0.5;  // without it colours are lost: Separation.LooksLikeThePicture
    const double luminance = 0.2126 * light[0] + 0.7152 * light[1] + 0.0722 * light[2];
    return {luminance, kColour * (light[0] - luminance), kColour * (light[1] - luminance),
            kColour * (light[2] - luminance)};
}

double dot(const Appearance& a, const Appearance& b) {
    return std::inner_product(a.begin(), a.end(), b.begin(), 0.0);
}

/// Finds the cover of each ink whose halftone looks most like a colour: least squares, and of equals the least cover.
/// By Gauss and Newton's method, in the box of covers, from dots side by side.
class Separator {
public:
    Separator(const InkSet& inks, Tone tone) : model_(inks, tone) {}

    Cover cover_of(const Light& light) const;

private:
    /// Decides between mixtures that look alike; with none greys are not black alone, and a hundredfold is seen:
    /// Separation.MakesGreysOfBlackAlone and LooksLikeThePicture.
    static constexpr double kPriceOfCover = 1e-4;

    Appearance missing(const Numbers& cover, const Light& light) const;
    double cost(const Numbers& cover, const Light& light) const;
    Numbers aim(const Numbers& cover, const Light& light) const;

    NeugebauerModel model_;
};

Appearance Separator::missing(const Numbers& cover, const Light& light) const {
    Channels left = channels(light);
    const Channels print = model_.light(cover);
    for (std::size_t c = 0; c < 3; ++c) left[c] -= print[c];
    return appearance(left);
}

double Separator::cost(const Numbers& cover, const Light& light) const {
    const Appearance left = missing(cover, light);
    return dot(left, left) / 2 + kPriceOfCover * std::accumulate(cover.begin(), cover.end(), 0.0);
}

/// The best cover, were all changes as they are at this one.
Numbers Separator::aim(const Numbers& cover, const Light& light) const {
    constexpr double kRidge = 1e-7;  // makes the products definite; far below kPriceOfCover, so that this decides
    BoundedLeastSquares problem;
    problem.count = model_.count();
    std::array<Appearance, kMostInks> changes{};
    Appearance wanted = missing(cover, light);
    for (std::size_t i = 0; i < problem.count; ++i) {
        changes[i] = appearance(model_.change(cover, i));
        for (std::size_t k = 0; k < wanted.size(); ++k) wanted[k] += cover[i] * changes[i][k];
    }
    for (std::size_t i = 0; i < problem.count; ++i) {
        problem.wanted[i] = dot(changes[i], wanted) - kPriceOfCover;
        for (std::size_t k = 0; k < problem.count; ++k) problem.products[i][k] = dot(changes[i], changes[k]);
        problem.products[i][i] += kRidge;
    }
    return problem.minimize();
}

Cover Separator::cover_of(const Light& light) const {
    constexpr int kMostSteps = 12;  // one is too few: Separation.LooksLikeThePicture
    constexpr double kLeastStep = 1.0 / 64, kExact = 1e-9;
    Numbers cover = aim({}, light);
    double cost = this->cost(cover, light);
    for (int step = 0; step < kMostSteps; ++step) {
        const Numbers to = aim(cover, light);
        double gain = 0;
        for (double share = 1; share >= kLeastStep && !(gain > 0); share /= 2) {
            Numbers next{};
            for (std::size_t i = 0; i < next.size(); ++i) next[i] = cover[i] + share * (to[i] - cover[i]);
            gain = cost - this->cost(next, light);
            if (gain > 0) cover = next;
        }
        if (!(gain > kExact)) break;
        cost -= gain;
    }
    Cover result{};
    std::ranges::transform(cover, result.begin(), [](double share) { return static_cast<float>(share); });
    return result;
}

/// A table over all colours, filled where it is asked. Between its nodes it is linear in each tetrahedron about the
/// greys, as are inks that stand for the least of a colour's channels.
class SeparationTable {
public:
    explicit SeparationTable(const Separator& separator) : separator_(separator), nodes_(kSide * kSide * kSide) {}

    Cover cover_of(const Light& light) {
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
            if (!(weight > 0)) return;
            const Cover& corner = at_node(node);
            for (std::size_t i = 0; i < kMostInks; ++i) cover[i] += weight * corner[i];
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

    const Cover& at_node(std::size_t node) {
        const auto at = [](std::size_t index) { return static_cast<float>(index) / (kSide - 1); };
        auto& cover = nodes_[node];
        if (!cover)
            cover = separator_.cover_of({at(node % kSide), at(node / kSide % kSide), at(node / (kSide * kSide))});
        return *cover;
    }

    const Separator separator_;
    std::vector<std::optional<Cover>> nodes_;  ///< red is the fastest axis
};

}  // namespace

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

Light halftoned(const InkSet& inks, std::span<const float> cover) {
    Numbers numbers{};
    std::ranges::copy(cover, numbers.begin());
    const Channels light = NeugebauerModel(inks, Tone::Linear).light(numbers);
    const auto share = [&](std::size_t channel) { return to_share(static_cast<float>(light[channel])); };
    return {share(0), share(1), share(2)};
}

std::vector<std::vector<float>> separate(const ColourPicture& picture, const InkSet& inks, Tone tone,
                                         const std::stop_token& stop) {
    assert(!inks.inks.empty() && inks.inks.size() <= kMostInks);
    const std::size_t pixels = picture.red.size();
    std::vector<std::vector<float>> coverage(inks.inks.size(), std::vector<float>(pixels));
    SeparationTable table(Separator(inks, tone));
    for (std::size_t p = 0; p < pixels; ++p) {
        if (p % static_cast<std::size_t>(picture.width) == 0 && stop.stop_requested()) break;
        const float alpha = picture.alpha.empty() ? 1 : to_share(picture.alpha[p]);
        const Cover cover = table.cover_of(mapped({picture.red[p], picture.green[p], picture.blue[p]}, tone));
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
