// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/analysis/analysis.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <complex>
#include <cstdlib>
#include <numbers>
#include <optional>
#include <string>
#include <tuple>
#include <utility>

#include "core/analysis/nonuniform_transform.h"
#include "core/analysis/spacing.h"
#include "core/geometry/hexagonal_spacing.h"

namespace ccdt {
namespace {

using Sets = std::span<const std::vector<Point>>;

constexpr double kMinFrequency = 1, kMaxFrequency = 16;
constexpr double kLow = 0.5;     // frequencies below this count as low
constexpr double kMargin = 0.1;  // width of the margin around a window's middle, relative to its sides

/// The domain's box, scaled to unit area without changing its shape, and the frequencies (i, j) that fit the box.
struct Frame {
    Box box;
    bool periodic;
    Point sides;  ///< sides of the box scaled to unit area

    explicit Frame(const Domain& domain) : box(domain.bounds()), periodic(domain.is_torus()) {
        const double ratio = std::sqrt(box.width()) / std::sqrt(box.height());
        sides = {ratio, 1 / ratio};
    }

    /// Returns the position of a point relative to the box, in [0, 1] x [0, 1].
    Point share_of(Point p) const {
        return {std::clamp((p.x - box.min.x) / box.width(), 0.0, 1.0),
                std::clamp((p.y - box.min.y) / box.height(), 0.0, 1.0)};
    }

    bool holds(Point p) const { return p.x >= box.min.x && p.x <= box.max.x && p.y >= box.min.y && p.y <= box.max.y; }

    /// Magnitude of a frequency for the box scaled to unit area, in cycles per unit of length.
    double frequency(int i, int j) const { return std::hypot(i / sides.x, j / sides.y); }

    /// Whether a frequency is left out. Frequency 0 measures only the number of points. For a window, all frequencies
    /// in the window's lobe around 0 are left out.
    bool is_excluded(int i, int j) const {
        const int lobe = periodic ? 0 : 1;
        return std::abs(i) <= lobe && std::abs(j) <= lobe;
    }
};

/// The grid of frequencies and the rings, chosen before any transform.
struct Plan {
    std::vector<double> densities;  ///< [sets] points per unit area
    double resolution = 0;          ///< square root of the mean density: the unit of frequencies
    int rings = 0;
    int highest_x = 0;
    int highest_y = 0;
};

tl::unexpected<Error> unusable(std::string message, std::string field) {
    return failure(ErrorCode::Unusable, std::move(message), std::move(field));
}

Result<void> check_set(std::size_t s, const std::vector<Point>& set, const Frame& frame) {
    for (std::size_t p = 0; p < set.size(); ++p) {
        if (frame.holds(set[p])) continue;
        return unusable("the point lies outside the domain", '/' + std::to_string(s) + '/' + std::to_string(p));
    }
    return {};
}

Result<void> check_sets(Sets sets, const Frame& frame) {
    if (sets.empty()) return unusable("there are no points", "");
    for (std::size_t s = 0; s < sets.size(); ++s) {
        const std::string field = '/' + std::to_string(s);
        if (sets[s].size() < 2) return unusable("a set must have at least 2 points", field);
        if (sets[s].size() != sets[0].size()) {
            return unusable("all sets must be of equal size; this one has " + std::to_string(sets[s].size()) +
                                " points, the first one " + std::to_string(sets[0].size()),
                            field);
        }
        if (auto checked = check_set(s, sets[s], frame); !checked) return checked;
    }
    return {};
}

/// Returns the density of points in the middle of a window, where the treatment of the border has no effect.
double middle_density(const std::vector<Point>& set, const Frame& frame) {
    const auto inner = [](double share) { return share > kMargin && share < 1 - kMargin; };
    const auto count = std::ranges::count_if(set, [&](Point p) {
        const Point share = frame.share_of(p);
        return inner(share.x) && inner(share.y);
    });
    return static_cast<double>(count) / ((1 - 2 * kMargin) * (1 - 2 * kMargin));
}

Result<std::vector<double>> densities_of(Sets sets, const Frame& frame) {
    std::vector<double> densities;
    for (std::size_t s = 0; s < sets.size(); ++s) {
        densities.push_back(frame.periodic ? static_cast<double>(sets[s].size()) : middle_density(sets[s], frame));
        if (densities.back() > 0) continue;
        return unusable("the middle of the window holds no point", '/' + std::to_string(s));
    }
    return densities;
}

double mean(const std::vector<double>& values) {
    double sum = 0;
    for (const double value : values) sum += value;
    return sum / static_cast<double>(values.size());
}

Result<Plan> make_plan(Sets sets, const Frame& frame, const AnalysisOptions& options) {
    auto densities = densities_of(sets, frame);
    if (!densities) return tl::make_unexpected(densities.error());
    Plan plan{*std::move(densities)};
    plan.resolution = std::sqrt(mean(plan.densities));
    const double rings = std::floor(options.max_frequency * plan.resolution);
    const double highest_x = std::floor((rings + 0.5) * frame.sides.x);
    const double highest_y = std::floor((rings + 0.5) * frame.sides.y);
    const double cells = NonuniformTransform::cells(highest_x, highest_y);
    if (!(cells <= static_cast<double>(kMaxTransformCells))) {
        return failure(ErrorCode::LimitExceeded,
                       "the spectrum of so many points up to this frequency needs a transform of " +
                           std::to_string(std::llround(std::min(cells, 1e18))) + " cells; the limit is " +
                           std::to_string(kMaxTransformCells),
                       "max_frequency");
    }
    plan.rings = static_cast<int>(rings);
    plan.highest_x = static_cast<int>(highest_x);
    plan.highest_y = static_cast<int>(highest_y);
    return plan;
}

/// Hann's window along one axis, scaled such that the mean of its square is 1.
double hann(double share) {
    return (1 - std::cos(2 * std::numbers::pi * share)) * std::sqrt(2.0 / 3);
}

/// Returns the Fourier transform of hann().
double hann_transform(int frequency) {
    constexpr double kHeights[] = {1, -0.5};
    return std::abs(frequency) <= 1 ? kHeights[std::abs(frequency)] * std::sqrt(2.0 / 3) : 0;
}

std::vector<WeightedPoint> weigh(const std::vector<Point>& set, const Frame& frame) {
    std::vector<WeightedPoint> points;
    points.reserve(set.size());
    for (const Point& p : set) {
        const Point share = frame.share_of(p);
        points.push_back({share, frame.periodic ? 1 : hann(share.x) * hann(share.y)});
    }
    return points;
}

double sum_of_squares(std::span<const WeightedPoint> points) {
    double sum = 0;
    for (const WeightedPoint& p : points) sum += p.weight * p.weight;
    return sum;
}

Spectrum make_spectrum(const Plan& plan) {
    Spectrum spectrum{2 * plan.highest_x + 1, 2 * plan.highest_y + 1, {}};
    spectrum.values.resize(static_cast<std::size_t>(spectrum.width) * static_cast<std::size_t>(spectrum.height));
    return spectrum;
}

/// Calls `visit(i, j)` for one of each pair of opposite frequencies, except (0, 0).
template <class Visit>
void for_each_pair(const Plan& plan, Visit visit) {
    for (int j = -plan.highest_y; j <= plan.highest_y; ++j) {
        for (int i = j > 0 ? 0 : 1; i <= plan.highest_x; ++i) visit(i, j);
    }
}

/// Adds the powers of sets to a spectrum. Computes all frequencies at once, or in parts if the grid would be too large.
class Periodogram {
public:
    /// All arguments must outlive this object.
    Periodogram(const Frame& frame, const Plan& plan, Spectrum& spectrum)
        : frame_(frame), plan_(plan), spectrum_(spectrum) {
        constexpr auto kMax = static_cast<double>(kMaxCells);
        if (NonuniformTransform::cells(plan.highest_x, plan.highest_y) <= kMax) {
            whole_.emplace(plan.highest_x, plan.highest_y);
            return;
        }
        // Each part needs two grids. The parts are as square as possible.
        const int even = static_cast<int>(std::sqrt(kMax / 2) / 4);
        const auto longest = [&](int other) { return static_cast<int>(kMax / 2 / (4 * std::max(other, 6))) / 4; };
        reach_y_ = std::min(plan.highest_y, plan.highest_x < even ? longest(plan.highest_x) : even);
        reach_x_ = std::min(plan.highest_x, longest(reach_y_));
        part_.emplace(reach_x_, reach_y_);
    }

    /// Adds the powers of a set. A stop ends the computation early; the spectrum must not be used then.
    /// @param points   points of the set; reordered
    /// @param density  density of the set
    /// @param share    weight of the set
    void add(std::vector<WeightedPoint>& points, double density, double share, const std::stop_token& stop) {
        if (whole_) {
            whole_->run(points, stop);
            for_each_pair(plan_, [&](int i, int j) { add(i, j, whole_->value(i, j), density, share); });
            return;
        }
        bring_together(points);
        for (int y = reach_y_ - plan_.highest_y; y - reach_y_ <= plan_.highest_y; y += 2 * reach_y_ + 1) {
            for (int x = reach_x_; x - reach_x_ <= plan_.highest_x; x += 2 * reach_x_ + 1) {
                part_->run(points, x, y, stop);
                if (stop.stop_requested()) return;
                add_part(x, y, density, share);
            }
        }
    }

private:
    /// Sorts points so that successive points are near each other.
    static void bring_together(std::vector<WeightedPoint>& points) {
        constexpr double kBands = 512;
        std::ranges::sort(points, {}, [](const WeightedPoint& point) {
            const Point p = point.position;
            return std::tuple(std::floor(kBands * p.y), p.x, p.y);
        });
    }

    /// Adds the frequencies of a part around (x, y): one of each pair of opposite frequencies.
    void add_part(int x, int y, double density, double share) {
        for (int j = y - reach_y_; j <= std::min(y + reach_y_, plan_.highest_y); ++j) {
            const int last = std::min(x + reach_x_, plan_.highest_x);
            for (int i = std::max(x - reach_x_, j > 0 ? 0 : 1); i <= last; ++i)
                add(i, j, part_->value(i - x, j - y), density, share);
        }
    }

    void add(int i, int j, std::complex<double> f, double density, double share) {
        if (!frame_.periodic) f -= density * hann_transform(i) * hann_transform(j);
        const double power = share * std::norm(f);
        spectrum_.at(i, j) += power;
        spectrum_.at(-i, -j) += power;
    }

    const Frame& frame_;
    const Plan& plan_;
    Spectrum& spectrum_;
    std::optional<NonuniformTransform> whole_;
    std::optional<ShiftedTransform> part_;
    int reach_x_ = 0, reach_y_ = 0;  ///< half the size of a part
};

void add_spacing(const std::vector<Point>& set, const Frame& frame, double density, const std::stop_token& stop,
                 Analysis& analysis) {
    std::vector<Point> points;
    points.reserve(set.size());
    for (const Point& p : set) {
        const Point share = frame.share_of(p);
        points.push_back({share.x * frame.sides.x, share.y * frame.sides.y});
    }
    const Spacing spacing = measure_spacing(points, frame.sides, frame.periodic, stop);
    const double densest = hexagonal_spacing(density);
    const auto sets = static_cast<double>(analysis.sets);
    analysis.min_distance += spacing.min / densest / sets;
    analysis.mean_distance += spacing.mean / densest / sets;
}

/// Statistics of the powers in a ring of frequencies. The mean is computed first, then the variance.
struct Ring {
    double count = 0;  ///< number of pairs of opposite frequencies
    double mean = 0;
    double variance = 0;
};

std::vector<Ring> measure_rings(const Frame& frame, const Plan& plan, const Spectrum& spectrum) {
    std::vector<Ring> rings(static_cast<std::size_t>(plan.rings) + 1);
    const auto for_each_member = [&](auto&& visit) {
        for_each_pair(plan, [&](int i, int j) {
            const double nearest = std::floor(frame.frequency(i, j) + 0.5);
            if (nearest > plan.rings || frame.is_excluded(i, j)) return;
            visit(rings[static_cast<std::size_t>(nearest)], spectrum.at(i, j));
        });
    };
    for_each_member([](Ring& ring, double power) {
        ++ring.count;
        ring.mean += power;
    });
    for (Ring& ring : rings) ring.mean /= std::max(1.0, ring.count);
    for_each_member([](Ring& ring, double power) { ring.variance += (power - ring.mean) * (power - ring.mean); });
    for (Ring& ring : rings) ring.variance /= std::max(1.0, ring.count - 1);
    return rings;
}

/// Returns the anisotropy of a ring in dB. Lower bounds keep the result finite where there is almost no power, as
/// between the peaks of a lattice.
double anisotropy(const Ring& ring) {
    constexpr double kMinVariance = 1e-30, kMinPower = 1e-15;
    const double power = std::max(ring.mean, kMinPower);
    return 10 * std::log10(std::max(ring.variance, kMinVariance) / (power * power));
}

void fill_curves(const Frame& frame, const Plan& plan, Analysis& analysis) {
    const auto rings = measure_rings(frame, plan, analysis.spectrum);
    for (std::size_t r = 1; r < rings.size(); ++r) {
        if (rings[r].count < 2) continue;
        analysis.frequency.push_back(static_cast<double>(r) / plan.resolution);
        analysis.power.push_back(rings[r].mean);
        analysis.anisotropy_db.push_back(anisotropy(rings[r]));
    }
}

std::optional<double> low_frequency_power(const Frame& frame, const Plan& plan, const Spectrum& spectrum) {
    double count = 0, sum = 0;
    for_each_pair(plan, [&](int i, int j) {
        if (frame.frequency(i, j) >= kLow * plan.resolution || frame.is_excluded(i, j)) return;
        ++count;
        sum += spectrum.at(i, j);
    });
    if (count == 0) return std::nullopt;
    return sum / count;
}

/// Transforms all sets and averages their powers. A stop ends the computation early; the result must not be used then.
Analysis measure(Sets sets, const Frame& frame, const Plan& plan, const std::stop_token& stop) {
    Analysis analysis;
    analysis.sets = sets.size();
    analysis.points = sets[0].size();
    analysis.unit = plan.resolution / std::sqrt(frame.box.width()) / std::sqrt(frame.box.height());
    analysis.spectrum = make_spectrum(plan);
    Periodogram powers(frame, plan, analysis.spectrum);
    for (std::size_t s = 0; s < sets.size() && !stop.stop_requested(); ++s) {
        auto points = weigh(sets[s], frame);
        const double share = 1 / (sum_of_squares(points) * static_cast<double>(sets.size()));
        powers.add(points, plan.densities[s], share, stop);
        add_spacing(sets[s], frame, plan.densities[s], stop, analysis);
    }
    fill_curves(frame, plan, analysis);
    analysis.low_frequency_power = low_frequency_power(frame, plan, analysis.spectrum);
    return analysis;
}

}  // namespace

Result<Analysis> analyse(Sets sets, const Domain& domain, const AnalysisOptions& options, const std::stop_token& stop) {
    assert(domain.is_box());
    if (!(options.max_frequency >= kMinFrequency && options.max_frequency <= kMaxFrequency)) {
        return failure(ErrorCode::Malformed, "max_frequency must be a number from 1 to 16", "max_frequency");
    }
    const Frame frame(domain);
    if (auto checked = check_sets(sets, frame); !checked) return tl::make_unexpected(checked.error());
    const auto plan = make_plan(sets, frame, options);
    if (!plan) return tl::make_unexpected(plan.error());
    Analysis analysis = measure(sets, frame, *plan, stop);
    if (stop.stop_requested()) return failure(ErrorCode::Stopped, "the analysis was stopped");
    if (analysis.frequency.empty()) return unusable("these points are too few for a spectrum", "");
    return analysis;
}

}  // namespace ccdt
