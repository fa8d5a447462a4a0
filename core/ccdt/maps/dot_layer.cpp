// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/maps/dot_layer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "core/ccdt/maps/dot_error.h"
#include "core/ccdt/plane/construction.h"
#include "core/ccdt/plane/fixed_area.h"
#include "core/ccdt/plane/fixed_choice.h"
#include "core/ccdt/polish/push.h"
#include "core/ccdt/relax/border.h"
#include "core/ccdt/relax/goals.h"
#include "core/geometry/hexagonal_spacing.h"
#include "core/mesh/flips.h"
#include "core/mesh/insertion.h"
#include "core/mesh/insertion_steps.h"
#include "core/mesh/inside.h"

namespace ccdt {

namespace {

constexpr double kMaxPush = 0.4;  ///< longest move, in radii; two dots at the wanted distance keep at least 0.6 of it
constexpr double kSmall = 0.01;   ///< share of the wanted area below which a triangle may be a needle
// Number of dots or triangles per task.
constexpr std::size_t kDots = 4096, kTriangles = 8192;

/// Returns the wanted doubled area of a triangle between discs with the given radii. For equal radii, this is the
/// doubled area of a triangle of the hexagonal grid. Along a straight border between small and large discs, the
/// distance between the first rows on the two sides is half a row of small discs plus half a row of large discs.
double doubled_area(double a, double b, double c) {
    const auto [least, most] = std::minmax({a, b, c});
    if (!(most > 0)) return 0;
    return std::sqrt(3.0) / 2 * (a + b) * (b + c) * (c + a) / (least + most);
}

}  // namespace

DotLayer::DotLayer(DotGround& ground, Domain land, const Options& options, const Control& control)
    : ground_(ground), land_(std::move(land)), options_(options), stop_(control.stop), executor_(*control.executor) {
    options_.sites = ground.dots();
}

/// Returns the number of the caller's units per unit of the unit frame.
double DotLayer::scale() const {
    return std::max(land_.bounds().width(), land_.bounds().height());
}

double DotLayer::radius(double density) const {
    return 0.5 * hexagonal_spacing(density) / scale();
}

/// Divides a border edge into steps, and returns its length up to the start and up to the end of each step. The unit is
/// the local distance between dots.
std::vector<double> DotLayer::length_in_dots(Point a, Point b) const {
    constexpr double kInward = 1e-3;
    constexpr int kSteps = 8;
    const Point along = b - a, inward{-along.y, along.x};
    const int steps = ground_.is_uniform() ? 1 : kSteps;
    std::vector<double> sums{0};
    for (int i = 0; i < steps; ++i) {
        const double density = ground_.around(land_.to_user(a + (i + 0.5) / steps * along + kInward * inward));
        const double length = std::sqrt(dot(along, along)) / steps;
        sums.push_back(sums.back() + (density > 0 ? length / (2 * radius(density)) : 0));
    }
    return sums;
}

Result<void> DotLayer::start() {
    const auto rounded = [this](Point p) { return land_.to_user(land_.to_unit(p)); };
    auto drawn = ground_.draw(options_.seed, rounded, executor_, stop_);
    if (!drawn) return tl::unexpected(drawn.error());
    dots_ = *std::move(drawn);
    ground_.find_overlaps(dots_, stop_);
    const Border border = make_border(
        land_, [this](Point a, Point b) { return length_in_dots(a, b); }, dots_.size());
    if (auto chosen = choose_fixed(border); !chosen) return chosen;
    const std::size_t sites = dots_.size() + fixed_.positions.size();
    auto empty = empty_mesh(land_, border, sites, stop_);
    if (!empty) return tl::unexpected(empty.error());
    placed_ = *std::move(empty);
    mesh().set_executor(executor_);
    mesh().fix_last(fixed_.positions.size());
    radii_.resize(sites);
    moves_.resize(sites);
    before_.resize(sites);
    spacings_.resize(sites);
    for (std::size_t i = 0; i < fixed_.positions.size(); ++i) {
        const std::size_t site = dots_.size() + i;
        insert_site(mesh(), static_cast<std::uint32_t>(site), fixed_.positions[i]);
        const double density = ground_.around(land_.to_user(fixed_.positions[i]));
        radii_[site] = radius(density > 0 ? density : static_cast<double>(dots_.size()) / land_.area());
        before_[site] = fixed_.positions[i];
    }
    if (auto inserted = insert_all(); !inserted) return inserted;
    trim(mesh());
    result_.trace.push_back(measure());
    if (stopping()) return failure(ErrorCode::Stopped, "stopped before there was a result");
    return {};
}

Result<void> DotLayer::choose_fixed(const Border& border) {
    const std::vector<Point> points = to_unit_frame(land_, options_.fixed);
    if (points.empty()) return {};
    double densest = static_cast<double>(dots_.size()) / land_.area();
    for (const Point& p : points) densest = std::max(densest, ground_.around(land_.to_user(p)));
    auto trial = empty_mesh(land_, border, points.size(), stop_);
    if (!trial) return tl::unexpected(trial.error());
    const double spacing = 1 / std::sqrt(densest) / scale();
    fixed_ = ccdt::choose_fixed(land_, points, std::vector<double>(points.size(), 1), spacing, trial->mesh);
    if (!fixed_.others.empty()) others_.emplace(land_, fixed_.others);
    return {};
}

Result<void> DotLayer::insert_all() {
    Result<void> inserted;
    for_insertion_steps(dots_.size(), [&](auto step) { return (inserted = insert_step(step)).has_value(); });
    return inserted;
}

/// Inserts dots into the mesh, in ascending order of their numbers.
Result<void> DotLayer::insert_step(std::span<const std::uint32_t> dots) {
    const auto draw = [this](std::uint32_t dot, int) { return land_.to_unit(dots_[dot].position); };
    std::vector<std::uint32_t> kept, remaining;
    for (const std::uint32_t dot : dots) (keeps_position(dot) ? kept : remaining).push_back(dot);
    const auto refused = insert_sites(mesh(), kept, draw, 1, land_.resolution(), stop_);
    remaining.insert(remaining.end(), refused.begin(), refused.end());
    for (const std::uint32_t dot : remaining) {
        if (stopping()) return failure(ErrorCode::Stopped, "stopped before there was a result");
        if (auto inserted = insert_anywhere(dot); !inserted) return inserted;
    }
    return {};
}

/// Whether a dot may stay at its initial position after rounding.
bool DotLayer::keeps_position(std::uint32_t dot) const {
    const auto& [position, feature] = dots_[dot];
    const Point rounded = land_.to_user(land_.to_unit(position));
    return rounded == position || ground_.allows(feature, rounded);
}

Result<void> DotLayer::insert_anywhere(std::uint32_t dot) {
    const auto accept = [&](Point user) {
        const Point p = land_.to_unit(user);
        return ground_.allows(dots_[dot].feature, land_.to_user(p)) && insert_site(mesh(), dot, p, land_.resolution());
    };
    std::optional<InteriorSampler> interior;
    return ground_.draw_again(dots_[dot].feature, options_.seed + dot, accept, interior);
}

/// Computes the radius of each dot: half of the distance that neighbours should have at the dot's current position.
void DotLayer::find_radii() {
    for_ranges(executor_, dots_.size(), kDots, [&](std::size_t begin, std::size_t end) {
        if (stopping()) return;
        for (std::size_t dot = begin; dot < end; ++dot) {
            const std::uint32_t feature = dots_[dot].feature;
            const bool is_known = dot > begin && dots_[dot - 1].feature == feature && ground_.is_uniform_in(feature);
            radii_[dot] = is_known ? radii_[dot - 1] : radius(ground_.at(feature, position(dot)));
        }
    });
}

/// Computes the wanted areas of all triangles. A border vertex counts with the mean radius of the triangle's dots.
void DotLayer::find_targets() {
    guard_ = {};
    find_radii();
    targets_.resize(mesh().triangle_count());
    for_ranges(executor_, targets_.size(), kTriangles, [&](std::size_t begin, std::size_t end) {
        for (auto t = static_cast<std::uint32_t>(begin); t < end; ++t) targets_[t] = target_of(t);
    });
}

double DotLayer::target_of(std::uint32_t triangle) const {
    const auto corners = mesh().corners(triangle);
    double sum = 0, dots = 0;
    for (const std::uint32_t v : corners) {
        if (!mesh().is_site(v)) continue;
        sum += radii_[v];
        dots += 1;
    }
    const auto radius = [&](std::uint32_t v) { return mesh().is_site(v) ? radii_[v] : sum / dots; };
    return dots > 0 ? doubled_area(radius(corners[0]), radius(corners[1]), radius(corners[2])) : 0;
}

/// Computes capacities and goals of all triangles. Returns the capacity variation.
double DotLayer::measure() {
    find_targets();
    capacities_.resize(targets_.size());
    for_ranges(executor_, targets_.size(), kTriangles, [&](std::size_t begin, std::size_t end) {
        for (auto t = static_cast<std::uint32_t>(begin); t < end; ++t)
            capacities_[t] = targets_[t] > 0 ? 0.5 * mesh().doubled_area(t) / targets_[t] : 0;
    });
    const double variation = set_goals(mesh(), static_cast<double>(mesh().site_count()),
                                       std::numeric_limits<double>::max(), capacities_, goals_);
    soften_borders();
    return variation;
}

/// Reduces the weight of triangles between dense and sparse dots. The error of such triangles is due to the sparse
/// dots, which cannot adapt. With full weight, these triangles would pull rows of dense dots onto the border.
void DotLayer::soften_borders() {
    const auto soften = [this](std::uint32_t triangle) {
        double least = std::numeric_limits<double>::max(), most = 0;
        for (const std::uint32_t v : mesh().corners(triangle)) {
            if (!mesh().is_site(v)) continue;
            least = std::min(least, radii_[v]);
            most = std::max(most, radii_[v]);
        }
        if (!(most > least)) return;
        const double share = least * least / (most * most);
        goals_[triangle].weight *= share;
        goals_[triangle].target *= share;
    };
    for_ranges(executor_, goals_.size(), kTriangles, [&](std::size_t begin, std::size_t end) {
        for (auto t = static_cast<std::uint32_t>(begin); t < end; ++t) soften(t);
    });
}

bool DotLayer::has_next_iteration() const {
    if (stopping() || result_.iterations >= options_.iterations) return false;
    return !(options_.tolerance && variation() < *options_.tolerance);
}

Point DotLayer::fenced(std::uint32_t dot, Point to) const {
    if (!std::isfinite(to.x) || !std::isfinite(to.y)) return mesh().point(dot);
    const Point wanted = land_.to_user(to);
    if (ground_.is_far_inside(dots_[dot].feature, wanted)) return to;
    const Point there = ground_.towards(dots_[dot].feature, position(dot), wanted);
    if (there == wanted) return to;
    const Point rounded = land_.to_unit(there);
    return ground_.allows(dots_[dot].feature, land_.to_user(rounded)) ? rounded : mesh().point(dot);
}

Relaxation& DotLayer::relaxation() {
    if (relaxation_) return *relaxation_;
    RelaxationOptions settings;
    if (has_polish(options_) && ground_.is_uniform()) settings.spring = kPolishedSpring;
    settings.least_height = std::max(settings.least_height, land_.resolution());
    const double least = *std::ranges::min_element(radii_);
    settings.small_area = kSmall * doubled_area(least, least, least);
    settings.fence = [this](std::uint32_t dot, Point to) { return fenced(dot, to); };
    return relaxation_.emplace(mesh(), placed_->border.corner, false, settings);
}

void DotLayer::relax(int passes) {
    relaxation().prepare(std::move(goals_), stop_);
    relaxation().pass(passes, stop_);
    goals_ = relaxation().take_goals().release();
}

void DotLayer::polish_between(const PolishSettings& settings) {
    constexpr int kFirst = 2;  // in earlier iterations, dots are not near their final positions
    if (result_.iterations < std::max(kFirst, options_.iterations - settings.early)) return;
    push_apart(settings.reach, settings.push, {});
    even_out();
}

bool DotLayer::iterate() {
    relax(options_.passes);
    if (!stopping()) restore_delaunay(mesh(), stop_);
    if (stopping()) return false;
    result_.trace.push_back(measure());
    ++result_.iterations;
    if (!has_next_iteration()) relaxation_.reset();
    return true;
}

void DotLayer::push_apart(double reach, double push, std::span<const Point> pushed) {
    for_ranges(executor_, dots_.size(), kDots, [&](std::size_t begin, std::size_t end) {
        for (auto dot = static_cast<std::uint32_t>(begin); dot < end; ++dot) {
            const Point by = pushed.empty() ? Point{} : 1 / scale() * pushed[dot];
            moves_[dot] = by + push_off_neighbours(dot, reach, push);
            if (others_) moves_[dot] = moves_[dot] + push_off_others(dot, reach, push);
            moves_[dot] = capped(moves_[dot], kMaxPush * radii_[dot]);
        }
    });
    if (!stopping()) apply();
}

/// Returns the move of a dot caused by the sites adjacent to it.
Point DotLayer::push_off_neighbours(std::uint32_t dot, double reach, double push) const {
    Point moved;
    const std::uint32_t first = mesh().edge_of(dot);
    std::uint32_t h = first;
    do {
        const std::uint32_t other = mesh().target(h);
        if (mesh().is_site(other)) {
            const Point along = mesh().along(h);
            const double both = radii_[dot] + radii_[other], least = reach * both;
            const double squared = ccdt::dot(along, along);
            // If the neighbour is fixed, the dot moves the whole distance.
            const double share = mesh().is_free(other) ? radii_[dot] / both : 1;
            if (squared < least * least)
                moved = moved - PairPush{least, 2 * push * share}.move(along, std::sqrt(squared));
        }
        h = mesh().twin(Triangulation::previous(h));
    } while (h != first);
    return moved;
}

/// Returns the move of a dot caused by fixed points without a vertex.
Point DotLayer::push_off_others(std::uint32_t dot, double reach, double push) const {
    const double least = 2 * reach * radii_[dot];
    return pushed_off(*others_, mesh().point(dot), least, {}, [&](std::uint32_t, double) {
        return PairPush{least, 2 * push};
    });
}

/// Creates the transport. Excess does not flow between dots whose densities differ by more than a factor of 2, because
/// the clearance of dense dots would obstruct the flow.
MeshTransport DotLayer::make_transport() const {
    constexpr double kMaxContrast = 2;
    auto measure = [error = DotError(ground_, land_, dots_)](std::span<const Point> positions,
                                                             std::span<double> errors) mutable {
        error.measure(positions, errors);
    };
    return {mesh(), std::move(measure), [this](std::uint32_t a, std::uint32_t b) {
                const auto [least, most] = std::minmax(radii_[a], radii_[b]);
                return most * most <= kMaxContrast * least * least;
            }};
}

void DotLayer::even_out() {
    if (!ground_.is_smooth() || !options_.fixed.empty()) return;
    if (!transport_) transport_.emplace(make_transport());
    std::ranges::transform(radii_, spacings_.begin(), [](double radius) { return 2 / hexagonal_spacing(1) * radius; });
    if (transport_->displacements(mesh(), spacings_, moves_, stop_)) apply();
}

void DotLayer::equalise(int passes) {
    restore_delaunay(mesh(), stop_);
    if (stopping()) return;
    measure();
    relax(passes);
    relaxation_.reset();
    if (!stopping()) find_targets();
}

double DotLayer::least_distance() const {
    double least = std::numeric_limits<double>::infinity();
    for (std::uint32_t t = 0; t < mesh().triangle_count(); ++t) {
        for (std::uint32_t i = 0; i < 3; ++i) {
            const std::uint32_t h = Triangulation::edge(t, i), a = mesh().origin(h), b = mesh().target(h);
            if (!mesh().is_free(std::min(a, b)) || !mesh().is_site(std::max(a, b))) continue;
            const double both = radii_[a] + radii_[b];
            least = std::min(least, dot(mesh().along(h), mesh().along(h)) / (both * both));
        }
    }
    return std::sqrt(least);
}

void DotLayer::apply() {
    for_ranges(executor_, dots_.size(), kDots, [&](std::size_t begin, std::size_t end) {
        for (auto dot = static_cast<std::uint32_t>(begin); dot < end; ++dot) {
            before_[dot] = mesh().point(dot);
            if (!(moves_[dot] == Point{})) mesh().points()[dot] = fenced(dot, before_[dot] + moves_[dot]);
        }
    });
    guard_.check(mesh(), before_, land_.resolution(), 0,
                 [this](std::uint32_t t, double area) { return targets_[t] > 0 && area >= kSmall * targets_[t]; });
}

void DotLayer::restore() {
    restore_delaunay(mesh(), stop_);
    if (!stopping()) find_targets();
}

void DotLayer::finish() {
    if (stopping()) return;
    restore_delaunay(mesh(), stop_);
    const double variation = measure();
    if (!stopping()) result_.polished = variation;
}

ClassDots DotLayer::collect() {
    ClassDots all;
    std::vector<std::uint32_t> order(dots_.size());
    std::iota(order.begin(), order.end(), 0u);
    std::ranges::stable_sort(order, {}, [&](std::uint32_t dot) { return dots_[dot].feature; });
    for (const std::uint32_t dot : order) {
        result_.points.push_back(position(dot));
        all.feature_of.push_back(dots_[dot].feature);
    }
    result_.stopped = stopping();
    all.dots = std::move(result_);
    return all;
}

}  // namespace ccdt
