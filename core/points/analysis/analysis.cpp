// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/points/analysis/analysis.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <complex>
#include <cstdlib>
#include <numbers>
#include <optional>
#include <string>
#include <tuple>
#include <utility>

#include "core/base/elementary.h"
#include "core/ccdt/maps/feature_area.h"
#include "core/ccdt/polish/nonuniform_transform.h"
#include "core/geometry/axes.h"
#include "core/geometry/hexagonal_spacing.h"
#include "core/points/analysis/polygon_taper.h"
#include "core/points/analysis/spacing.h"

namespace ccdt {
namespace {

template <class P>
using Sets = std::span<const std::vector<P>>;

constexpr double kMinFrequency = 1, kMaxFrequency = 16;
constexpr double kMargin = 0.1;  // width of the margin around a window's middle, relative to its sides

/// A frequency, in cycles along each side of the domain. In the plane, z = 0.
struct Wave {
    int x, y, z;
};

/// Returns Hann's window along one axis, scaled such that the mean of its square is 1.
double hann(double share) {
    return (1 - elementary::cos(2 * std::numbers::pi * share)) * std::sqrt(2.0 / 3);
}

/// Returns the Fourier transform of hann().
double hann_transform(int frequency) {
    constexpr double kHeights[] = {1, -0.5};
    return std::abs(frequency) <= 1 ? kHeights[std::abs(frequency)] * std::sqrt(2.0 / 3) : 0;
}

/// The domain's box, scaled to unit area or volume without changing its shape, and the waves that fit the box.
/// @tparam P  Point or Point3
template <class P>
struct UnitBox {
    P min, max;
    bool periodic;
    P size = max - min;                   ///< sides of the box
    P sides{};                            ///< sides of the box scaled to unit area or volume
    double content = 1;                   ///< share of the box that the domain covers
    const PolygonTaper* taper = nullptr;  ///< window of polygons; otherwise, the window is Hann's

    UnitBox(const P& lowest, const P& highest, bool is_torus) : min(lowest), max(highest), periodic(is_torus) {
        for_axes([&](std::size_t axis) { along(sides, axis) = along(size, axis) * per_side(1); });
    }

    template <class Visit>
    static void for_axes(Visit&& visit) {
        for (std::size_t axis = 0; axis < kAxes<P>; ++axis) visit(axis);
    }

    /// Returns the side of a square or a cube.
    static double root(double content) { return kAxes<P> == 2 ? std::sqrt(content) : elementary::cbrt(content); }

    /// Returns a value divided by the side of the square or cube that is as large as the box.
    double per_side(double value) const {
        for_axes([&](std::size_t axis) { value /= root(along(size, axis)); });
        return value;
    }

    /// Returns the position of a point relative to the box, with coordinates in [0, 1].
    P share_of(P p) const {
        for_axes([&](std::size_t axis) {
            along(p, axis) = std::clamp((along(p, axis) - along(min, axis)) / along(size, axis), 0.0, 1.0);
        });
        return p;
    }

    bool holds(P p) const {
        bool inside = true;
        for_axes([&](std::size_t axis) {
            inside = inside && along(p, axis) >= along(min, axis) && along(p, axis) <= along(max, axis);
        });
        return inside;
    }

    /// Returns the magnitude of a frequency for the box scaled to unit area or volume, in cycles per unit of length.
    double frequency(Wave wave) const {
        const double flat = elementary::hypot(wave.x / sides.x, wave.y / sides.y);
        if constexpr (kAxes<P> == 3) return elementary::hypot(flat, wave.z / sides.z);
        return flat;
    }

    /// Returns the weight of a point; 1 on a torus.
    double weight(const P& share) const {
        if (taper) return taper->weight({share.x, share.y});
        double weight = 1;
        if (!periodic) for_axes([&](std::size_t axis) { weight *= hann(along(share, axis)); });
        return weight;
    }

    /// Returns the transform of weight(), of a window.
    std::complex<double> window(Wave wave) const {
        if (taper) return taper->transform(wave.x, wave.y);
        const double flat = hann_transform(wave.x) * hann_transform(wave.y);
        if constexpr (kAxes<P> == 3) return flat * hann_transform(wave.z);
        return flat;
    }

    /// Whether a frequency is left out. Frequency 0 measures only the number of points. For a window, all frequencies
    /// in the window's lobe around 0 are left out.
    bool is_excluded(Wave wave) const {
        constexpr double kLobe = 0.05;  // power at the edge of the lobe, relative to that at 0
        if (taper) return std::norm(window(wave)) > kLobe * std::norm(window({}));
        const int lobe = periodic ? 0 : 1;
        return std::abs(wave.x) <= lobe && std::abs(wave.y) <= lobe && std::abs(wave.z) <= lobe;
    }

    /// Returns the frequency below which frequencies count as low. In space, it is half the principal frequency of the
    /// densest packing.
    static double low() { return kAxes<P> == 2 ? 0.5 : std::sqrt(1.5) / kCubicSpacing / 2; }
};

/// The grid of frequencies and the rings, chosen before any transform.
struct Plan {
    std::vector<double> densities;  ///< [sets] points per unit area or volume
    double resolution = 0;          ///< square or cubic root of the mean density: the unit of frequencies
    int rings = 0;
    Wave highest{};
};

tl::unexpected<Error> unusable(std::string message, std::string field) {
    return failure(ErrorCode::Unusable, std::move(message), std::move(field));
}

template <class P>
Result<void> check_set(std::size_t s, const std::vector<P>& set, const UnitBox<P>& frame) {
    for (std::size_t p = 0; p < set.size(); ++p) {
        if (frame.holds(set[p])) continue;
        return unusable("the point lies outside the domain", '/' + std::to_string(s) + '/' + std::to_string(p));
    }
    return {};
}

template <class P>
Result<void> check_sets(Sets<P> sets, const UnitBox<P>& frame) {
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
template <class P>
double middle_density(const std::vector<P>& set, const UnitBox<P>& frame) {
    const auto count = std::ranges::count_if(set, [&](const P& p) {
        const P share = frame.share_of(p);
        bool inner = true;
        frame.for_axes([&](std::size_t axis) {
            inner = inner && along(share, axis) > kMargin && along(share, axis) < 1 - kMargin;
        });
        return inner;
    });
    return static_cast<double>(count) / elementary::pow(1 - 2 * kMargin, kAxes<P>);
}

/// Returns the density of points in a domain: in polygons the mean, weighted by the taper once there is one.
template <class P>
double density_of(const std::vector<P>& set, const UnitBox<P>& frame) {
    if (frame.taper) {
        double sum = 0;
        for (const P& p : set) sum += frame.weight(frame.share_of(p));
        return sum / frame.window({}).real();
    }
    const bool is_window = !frame.periodic && frame.content == 1;
    return is_window ? middle_density(set, frame) : static_cast<double>(set.size()) / frame.content;
}

template <class P>
Result<std::vector<double>> densities_of(Sets<P> sets, const UnitBox<P>& frame) {
    std::vector<double> densities;
    for (std::size_t s = 0; s < sets.size(); ++s) {
        densities.push_back(density_of(sets[s], frame));
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

template <class P>
Result<Plan> make_plan(Sets<P> sets, const UnitBox<P>& frame, const AnalysisOptions& options) {
    auto densities = densities_of(sets, frame);
    if (!densities) return tl::make_unexpected(densities.error());
    Plan plan{*std::move(densities)};
    plan.resolution = frame.root(mean(plan.densities));
    const double rings = std::floor(options.max_frequency * plan.resolution);
    std::array<double, 3> highest{};
    frame.for_axes([&](std::size_t axis) { highest[axis] = std::floor((rings + 0.5) * along(frame.sides, axis)); });
    const double cells = NonuniformTransform::cells(highest[0], highest[1], highest[2]);
    if (!(cells <= static_cast<double>(kMaxTransformCells))) {
        return failure(ErrorCode::LimitExceeded,
                       "the spectrum of so many points up to this frequency needs a transform of " +
                           std::to_string(std::llround(std::min(cells, 1e18))) + " cells; the limit is " +
                           std::to_string(kMaxTransformCells),
                       "max_frequency");
    }
    plan.rings = static_cast<int>(rings);
    plan.highest = {static_cast<int>(highest[0]), static_cast<int>(highest[1]), static_cast<int>(highest[2])};
    return plan;
}

template <class P>
std::vector<BasicWeightedPoint<P>> weigh(const std::vector<P>& set, const UnitBox<P>& frame) {
    std::vector<BasicWeightedPoint<P>> points;
    points.reserve(set.size());
    for (const P& p : set) {
        const P share = frame.share_of(p);
        points.push_back({share, frame.weight(share)});
    }
    return points;
}

template <class P>
double sum_of_squares(const std::vector<BasicWeightedPoint<P>>& points) {
    double sum = 0;
    for (const auto& p : points) sum += p.weight * p.weight;
    return sum;
}

/// Powers of all waves: a spectrum for each frequency along z, from the lowest one on. In the plane, there is only one.
class Layers {
public:
    explicit Layers(Wave highest) : layers_(2 * static_cast<std::size_t>(highest.z) + 1) {
        for (Spectrum& layer : layers_) {
            layer = {2 * highest.x + 1, 2 * highest.y + 1, {}};
            layer.values.resize(static_cast<std::size_t>(layer.width) * static_cast<std::size_t>(layer.height));
        }
    }

    double& at(Wave wave) { return layers_[static_cast<std::size_t>(wave.z) + layers_.size() / 2].at(wave.x, wave.y); }
    Spectrum& middle() { return layers_[layers_.size() / 2]; }

private:
    std::vector<Spectrum> layers_;
};

/// Calls visit(wave) for the frequencies within `reach` of `middle` and up to `highest`, except 0. Visits only one of
/// each pair of opposite frequencies.
template <class Visit>
void for_each_pair(Wave highest, Wave middle, Wave reach, Visit visit) {
    for (int k = std::max(middle.z - reach.z, -highest.z); k <= std::min(middle.z + reach.z, highest.z); ++k) {
        for (int j = std::max(middle.y - reach.y, -highest.y); j <= std::min(middle.y + reach.y, highest.y); ++j) {
            const int first = j > 0 || (j == 0 && k > 0) ? 0 : 1;
            for (int i = std::max(middle.x - reach.x, first); i <= std::min(middle.x + reach.x, highest.x); ++i)
                visit(Wave{i, j, k});
        }
    }
}
template <class Visit>
void for_each_pair(const Plan& plan, Visit visit) {
    for_each_pair(plan.highest, {}, plan.highest, visit);
}

/// Returns the reach of the parts into which the frequencies are divided, half of a part's size. The two grids of a
/// part have at most kMaxCells cells. Parts are as cubic as possible.
Wave reach_of_parts(Wave highest, std::size_t axes) {
    std::array<int*, 3> reach{&highest.x, &highest.y, &highest.z};
    std::ranges::sort(reach.begin(), reach.begin() + static_cast<std::ptrdiff_t>(axes), {},
                      [](int* side) { return *side; });
    double cells = static_cast<double>(kMaxCells) / 2;
    for (std::size_t rest = axes; rest > 0; --rest) {
        int& side = *reach[axes - rest];
        side = std::min(side, static_cast<int>(elementary::pow(cells, 1 / static_cast<double>(rest)) / 4));
        cells /= 4 * std::max(side, 6);
    }
    return highest;
}

/// Adds the powers of sets to a spectrum. Computes all frequencies at once, or in parts if the grid would be too large.
template <class P>
class Periodogram {
public:
    /// All arguments must outlive this object.
    Periodogram(const UnitBox<P>& frame, const Plan& plan, Layers& powers)
        : frame_(frame), plan_(plan), powers_(powers) {
        const auto [x, y, z] = plan.highest;
        if (NonuniformTransform::cells(x, y, z) <= static_cast<double>(kMaxCells)) {
            whole_.emplace(x, y, z);
            return;
        }
        reach_ = reach_of_parts(plan.highest, kAxes<P>);
        part_.emplace(reach_.x, reach_.y, reach_.z);
    }

    /// Adds the powers of a set. A stop ends the computation early; the spectrum must not be used then.
    /// @param points   points of the set; reordered
    /// @param density  density of the set
    /// @param share    weight of the set
    void add(std::vector<BasicWeightedPoint<P>>& points, double density, double share, const std::stop_token& stop) {
        if (whole_) {
            whole_->run(points, stop);
            for_each_pair(plan_, [&](Wave w) { add(w, whole_->value(w.x, w.y, w.z), density, share); });
            return;
        }
        bring_together(points);
        const auto [highest_x, highest_y, highest_z] = plan_.highest;
        for (int z = reach_.z - highest_z; z - reach_.z <= highest_z; z += 2 * reach_.z + 1) {
            for (int y = reach_.y - highest_y; y - reach_.y <= highest_y; y += 2 * reach_.y + 1) {
                for (int x = reach_.x; x - reach_.x <= highest_x; x += 2 * reach_.x + 1) {
                    part_->run(points, {x, y, z}, stop);
                    if (stop.stop_requested()) return;
                    for_each_pair(plan_.highest, {x, y, z}, reach_,
                                  [&](Wave w) { add(w, part_->value(w.x - x, w.y - y, w.z - z), density, share); });
                }
            }
        }
    }

private:
    /// Sorts points so that successive points are near each other.
    static void bring_together(std::vector<BasicWeightedPoint<P>>& points) {
        std::ranges::sort(points, {}, [](const BasicWeightedPoint<P>& point) {
            const P& p = point.position;
            if constexpr (kAxes<P> == 3)
                return std::tuple(std::floor(64 * p.z), std::floor(64 * p.y), p.x, p.y, p.z);
            else
                return std::tuple(std::floor(512 * p.y), p.x, p.y);
        });
    }

    void add(Wave wave, std::complex<double> f, double density, double share) {
        if (!frame_.periodic) f -= density * frame_.window(wave);
        const double power = share * std::norm(f);
        powers_.at(wave) += power;
        powers_.at({-wave.x, -wave.y, -wave.z}) += power;
    }

    const UnitBox<P>& frame_;
    const Plan& plan_;
    Layers& powers_;
    std::optional<NonuniformTransform> whole_;
    std::optional<ShiftedTransform> part_;
    Wave reach_{};  ///< half the size of a part
};

template <class P>
void add_spacing(const std::vector<P>& set, const UnitBox<P>& frame, double density, const std::stop_token& stop,
                 Analysis& analysis) {
    std::vector<P> points;
    points.reserve(set.size());
    for (const P& p : set) {
        P& position = points.emplace_back(frame.share_of(p));
        frame.for_axes([&](std::size_t axis) { along(position, axis) *= along(frame.sides, axis); });
    }
    Spacing spacing;
    if constexpr (kAxes<P> == 2) {
        // Hanisch's estimate: the nearest point of a point may lie beyond the border if the border is nearer.
        const auto weigh = [&](Point p, double distance) {
            const bool is_known = frame.taper->depth({p.x / frame.sides.x, p.y / frame.sides.y}) >= distance;
            return is_known ? 1 / frame.taper->share_at_depth(distance) : 0;
        };
        spacing = measure_spacing(points, frame.sides, frame.periodic, stop,
                                  frame.taper ? WeighDistance(weigh) : WeighDistance());
    } else {
        spacing = measure_spacing(points, frame.sides, frame.periodic, stop);
    }
    const double densest = densest_spacing(density, kAxes<P> == 3);
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

template <class P>
std::vector<Ring> measure_rings(const UnitBox<P>& frame, const Plan& plan, Layers& powers) {
    std::vector<Ring> rings(static_cast<std::size_t>(plan.rings) + 1);
    const auto for_each_member = [&](auto&& visit) {
        for_each_pair(plan, [&](Wave wave) {
            const double nearest = std::floor(frame.frequency(wave) + 0.5);
            if (nearest > plan.rings || frame.is_excluded(wave)) return;
            visit(rings[static_cast<std::size_t>(nearest)], powers.at(wave));
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
    return 10 * elementary::log10(std::max(ring.variance, kMinVariance) / (power * power));
}

template <class P>
void fill_curves(const UnitBox<P>& frame, const Plan& plan, Layers& powers, Analysis& analysis) {
    const auto rings = measure_rings(frame, plan, powers);
    for (std::size_t r = 1; r < rings.size(); ++r) {
        if (rings[r].count < 2) continue;
        analysis.frequency.push_back(static_cast<double>(r) / plan.resolution);
        analysis.power.push_back(rings[r].mean);
        analysis.anisotropy_db.push_back(anisotropy(rings[r]));
    }
}

template <class P>
std::optional<double> low_frequency_power(const UnitBox<P>& frame, const Plan& plan, Layers& powers) {
    double count = 0, sum = 0;
    for_each_pair(plan, [&](Wave wave) {
        if (frame.frequency(wave) >= frame.low() * plan.resolution || frame.is_excluded(wave)) return;
        ++count;
        sum += powers.at(wave);
    });
    if (count == 0) return std::nullopt;
    return sum / count;
}

/// Transforms all sets and averages their powers. A stop ends the computation early; the result must not be used then.
template <class P>
Analysis measure(Sets<P> sets, const UnitBox<P>& frame, const Plan& plan, const std::stop_token& stop) {
    Analysis analysis;
    analysis.sets = sets.size();
    analysis.points = sets[0].size();
    analysis.unit = frame.per_side(plan.resolution);
    Layers powers(plan.highest);
    Periodogram<P> periodogram(frame, plan, powers);
    for (std::size_t s = 0; s < sets.size() && !stop.stop_requested(); ++s) {
        auto points = weigh(sets[s], frame);
        const double share = 1 / (sum_of_squares(points) * static_cast<double>(sets.size()));
        periodogram.add(points, plan.densities[s], share, stop);
        add_spacing(sets[s], frame, plan.densities[s], stop, analysis);
    }
    fill_curves(frame, plan, powers, analysis);
    analysis.low_frequency_power = low_frequency_power(frame, plan, powers);
    analysis.spectrum = std::move(powers.middle());
    return analysis;
}

/// Checks the arguments of an analysis and makes its plan. Errors: those of check_analysis().
template <class P>
Result<Plan> prepare(Sets<P> sets, const UnitBox<P>& frame, const AnalysisOptions& options) {
    bool is_proper = true;
    frame.for_axes([&](std::size_t axis) {
        const double side = along(frame.size, axis);
        is_proper = is_proper && side > 0 && std::isfinite(side);
    });
    if (!is_proper) return unusable("the sides of the domain must be positive and finite", "domain");
    if (!(options.max_frequency >= kMinFrequency && options.max_frequency <= kMaxFrequency)) {
        return failure(ErrorCode::Malformed, "max_frequency must be a number from 1 to 16", "max_frequency");
    }
    return check_sets(sets, frame).and_then([&] { return make_plan(sets, frame, options); });
}

template <class P>
Result<Analysis> analyse_in(const UnitBox<P>& frame, Sets<P> sets, const AnalysisOptions& options,
                            const std::stop_token& stop) {
    const auto plan = prepare(sets, frame, options);
    if (!plan) return tl::make_unexpected(plan.error());
    Analysis analysis = measure(sets, frame, *plan, stop);
    if (stop.stop_requested()) return failure(ErrorCode::Stopped, "the analysis was stopped");
    if (analysis.frequency.empty()) return unusable("these points are too few for a spectrum", "");
    return analysis;
}

UnitBox<Point> frame_of(const Domain& domain) {
    const Box& bounds = domain.bounds();
    UnitBox<Point> frame(bounds.min, bounds.max, domain.is_torus());
    if (!domain.is_box()) {
        const Point sides = domain.unit_bounds().max;
        frame.content = std::min(1.0, domain.unit_area() / (sides.x * sides.y));
    }
    return frame;
}

Result<void> check_inside(Sets<Point> sets, const Domain& domain) {
    const FeatureArea area(domain, {}, sets[0].size());
    for (std::size_t s = 0; s < sets.size(); ++s) {
        for (std::size_t p = 0; p < sets[s].size(); ++p) {
            if (area.contains(sets[s][p])) continue;
            return unusable("the point lies outside the polygons, or on their border",
                            '/' + std::to_string(s) + '/' + std::to_string(p));
        }
    }
    return {};
}

Result<Analysis> analyse_in_polygons(const Domain& domain, Sets<Point> sets, const AnalysisOptions& options,
                                     const std::stop_token& stop) {
    const auto checked = check_analysis(sets, domain, options).and_then([&] { return check_inside(sets, domain); });
    if (!checked) return tl::make_unexpected(checked.error());
    const PolygonTaper taper(domain);
    if (!taper.is_wide_enough())
        return unusable("the polygons are too narrow, relative to their extent, for an analysis", "domain");
    UnitBox<Point> frame = frame_of(domain);
    frame.taper = &taper;
    return analyse_in(frame, sets, options, stop);
}

}  // namespace

Result<void> check_analysis(Sets<Point> sets, const Domain& domain, const AnalysisOptions& options) {
    return prepare(sets, frame_of(domain), options).map([](const Plan&) {});
}

Result<void> check_analysis(Sets<Point3> sets, Point3 sides, bool periodic, const AnalysisOptions& options) {
    return prepare(sets, UnitBox<Point3>({}, sides, periodic), options).map([](const Plan&) {});
}

Result<Analysis> analyse(Sets<Point> sets, const Domain& domain, const AnalysisOptions& options,
                         const std::stop_token& stop) {
    if (!domain.is_box()) return analyse_in_polygons(domain, sets, options, stop);
    return analyse_in(frame_of(domain), sets, options, stop);
}

Result<Analysis> analyse(Sets<Point3> sets, Point3 sides, bool periodic, const AnalysisOptions& options,
                         const std::stop_token& stop) {
    return analyse_in(UnitBox<Point3>({}, sides, periodic), sets, options, stop);
}

}  // namespace ccdt
