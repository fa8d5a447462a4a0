// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/maps/dot_ground.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>
#include <string>
#include <utility>

#include "core/base/random.h"
#include "core/ccdt/plane/start.h"
#include "core/ccdt/relax/border.h"
#include "core/ccdt/relax/capacity_integral.h"
#include "core/geometry/hexagonal_spacing.h"
#include "core/mesh/inside.h"
#include "core/mesh/triangulation.h"

namespace ccdt {

namespace {

std::string field_of(std::size_t feature) {
    return "features/" + std::to_string(feature);
}

tl::unexpected<Error> too_thin(std::size_t feature) {
    return failure(ErrorCode::Unusable, "the feature is too thin to hold its points strictly inside",
                   field_of(feature));
}

/// Returns the seed for a feature's dots of one class: below 2^53, like all seeds.
std::uint64_t seed_of(std::uint64_t seed, std::size_t number, std::size_t feature) {
    constexpr int kSeedBits = 53, kClassBits = 40;
    return Random(seed, (static_cast<std::uint64_t>(number) << kClassBits) + feature).bits() >> (64 - kSeedBits);
}

/// Returns a sampler of a domain, in its unit frame.
std::optional<InteriorSampler> interior_of(const Domain& area) {
    const auto scaffold = triangulate(bare_border(area));
    if (!scaffold) return std::nullopt;
    return InteriorSampler(inside_triangles(mesh_of_border(0, *scaffold)));
}

/// Returns the position of a point along Morton's curve.
/// @param share  position in the box that the curve fills, in [0, 1] x [0, 1]
std::uint64_t along_curve(Point share) {
    std::uint64_t position = 0;
    for (int bit = 15; bit >= 0; --bit) {
        const auto digit = [bit](double v) { return static_cast<std::uint64_t>(v * 0xffff) >> bit & 1; };
        position = position << 2 | digit(share.y) << 1 | digit(share.x);
    }
    return position;
}

}  // namespace

Result<DotGround> DotGround::create(const Map& map, std::size_t number, Executor& executor,
                                    const std::stop_token& stop) {
    DotGround ground(map, number);
    ground.find_fixed();
    for (std::size_t i = 0; i < map.features.size(); ++i) {
        const MapFeature& feature = map.features[i];
        const std::size_t dots = feature.dots[number];
        ground.dots_ += dots;
        double capacity = feature.area.area();
        if (dots > 0 && !map.density.is_uniform()) {
            double largest = 0;
            const auto own = ground.cut_out(feature.area, largest);
            const double cells = own ? CapacityIntegral(feature.area, *own).total() : 0;
            if (!(cells > 0)) {
                return failure(ErrorCode::Unusable, "the density is zero all over a feature that has points",
                               field_of(i));
            }
            const Box& box = feature.area.bounds();
            const double cell = box.width() / own->width() * (box.height() / own->height());
            capacity = std::ldexp(cells * cell, std::ilogb(largest));
        }
        const auto each = static_cast<std::uint32_t>(i);
        double sites = static_cast<double>(dots);
        if (dots > 0 && !ground.fixed_.empty() && !ground.fixed_[i].empty()) {
            const auto own = ground.density_of(each);
            if (!own) return tl::unexpected(own.error());
            sites = StartSites(feature.area, *own, ground.start_options(each, 0)).fixed_area().sites;
        }
        ground.wanted_.push_back(sites / capacity);
    }
    ground.overlaps_.resize(map.features.size());
    ground.fences_.resize(map.features.size());
    executor.run(ground.fences_.size(), [&](std::size_t i) {
        if (!stop.stop_requested()) ground.fences_[i] = ground.make_fence(static_cast<std::uint32_t>(i));
    });
    if (stop.stop_requested()) return failure(ErrorCode::Stopped, "stopped before there was a result");
    return ground;
}

/// Assigns fixed points to the features that contain them.
void DotGround::find_fixed() {
    if (map_.fixed.empty()) return;
    fixed_.resize(map_.features.size());
    for (const Point& p : map_.fixed) {
        map_.index.for_near(p, [&](std::uint32_t feature) {
            if (map_.areas[feature].contains(p)) fixed_[feature].push_back(p);
        });
    }
}

/// Returns the density over the bounding box of a feature.
Result<Density> DotGround::density_of(std::uint32_t feature) const {
    double largest = 0;
    return is_uniform() ? Result<Density>(Density::uniform()) : cut_out(map_.features[feature].area, largest);
}

/// Returns the options for drawing the initial dots of a feature.
Options DotGround::start_options(std::uint32_t feature, std::uint64_t seed) const {
    Options options;
    options.sites = dots(feature);
    options.seed = seed;
    if (!fixed_.empty()) options.fixed = fixed_[feature];
    return options;
}

/// Creates the area of a feature, in which dots keep a clearance from sparser features. Almost no dots push back from a
/// sparser feature, so without clearance rows of dots would be pushed onto the border. Between similar densities there
/// is no clearance, so that borders do not show.
FeatureArea DotGround::make_fence(std::uint32_t feature) const {
    constexpr double kClear = 0.3;    // relative to the distance of neighbours; half a row would be 0.43
    constexpr double kSteepness = 2;  // no clearance if the density outside is at least half the density inside
    constexpr double kThin = 0.5;     // limit on the clearance relative to the feature's width
    // Distance beyond the border at which the density is sampled, relative to the distance of neighbours.
    constexpr double kBeyond = 1e-3;
    constexpr std::size_t kCells = 4;  // number of cells of the grid per dot
    const Domain& area = map_.features[feature].area;
    if (dots(feature) == 0) return map_.areas[feature];
    double perimeter = 0;
    for (const Ring& ring : area.rings()) {
        for (std::size_t i = 0; i < ring.size(); ++i) {
            const Point along = area.to_user(ring[(i + 1) % ring.size()]) - area.to_user(ring[i]);
            perimeter += std::sqrt(dot(along, along));
        }
    }
    const double width = 2 * area.area() / perimeter;
    const auto clearance = [&](Point middle, Point inwards) {
        const double inside = own(feature, middle);
        if (!(inside > 0)) return 0.0;
        const double distance = hexagonal_spacing(inside);
        const double share = around(middle - kBeyond * distance * inwards) / inside;
        return std::min(kClear * std::max(0.0, 1 - kSteepness * share) * distance, kThin * width);
    };
    return FeatureArea(area, clearance, kCells * dots(feature));
}

double DotGround::density(Point p) const {
    const Density& density = map_.density;
    if (density.is_uniform()) return 1;
    const auto index = [](double share, int cells) {
        return std::clamp(static_cast<int>(std::clamp(share, 0.0, 1.0) * cells), 0, cells - 1);
    };
    return density.value(index((p.x - map_.box.min.x) / map_.box.width(), density.width()),
                         index((p.y - map_.box.min.y) / map_.box.height(), density.height()));
}

/// Returns the part of the density over a domain, stretched over the domain's bounding box.
/// @param largest  out: largest value, before Density::grid() scales the values
Result<Density> DotGround::cut_out(const Domain& area, double& largest) const {
    static constexpr double kFiner = 2, kMax = 1024;
    const Box& box = area.bounds();
    const auto cells = [](double share, int of) {
        return static_cast<int>(std::clamp(std::ceil(kFiner * share * of), 1.0, kMax));
    };
    const int columns = cells(box.width() / map_.box.width(), map_.density.width());
    const int rows = cells(box.height() / map_.box.height(), map_.density.height());
    std::vector<double> values;
    for (int row = 0; row < rows; ++row) {
        for (int column = 0; column < columns; ++column)
            values.push_back(density(
                {box.min.x + (column + 0.5) / columns * box.width(), box.min.y + (row + 0.5) / rows * box.height()}));
    }
    largest = *std::ranges::max_element(values);
    return Density::grid(columns, rows, std::span<const double>(values));
}

std::vector<std::uint32_t> DotGround::order() const {
    std::vector<std::uint64_t> positions;
    for (const MapFeature& feature : map_.features) {
        const Box& box = feature.area.bounds();
        const Point middle = 0.5 * (box.min + box.max) - map_.box.min;
        positions.push_back(along_curve(
            {std::clamp(middle.x / map_.box.width(), 0.0, 1.0), std::clamp(middle.y / map_.box.height(), 0.0, 1.0)}));
    }
    std::vector<std::uint32_t> order(positions.size());
    std::iota(order.begin(), order.end(), 0u);
    std::ranges::stable_sort(order, {}, [&](std::uint32_t i) { return positions[i]; });
    return order;
}

Result<std::vector<FeatureDot>> DotGround::draw(std::uint64_t seed, const std::function<Point(Point)>& rounded,
                                                Executor& executor, const std::stop_token& stop) const {
    std::vector<FeatureDot> all(dots_);
    const std::vector<std::uint32_t> order = this->order();
    std::vector<std::span<FeatureDot>> shares;
    for (std::span<FeatureDot> rest = all; const std::uint32_t feature : order) {
        shares.push_back(rest.first(dots(feature)));
        rest = rest.subspan(dots(feature));
    }
    std::vector<Result<void>> drawn(order.size());
    executor.run(order.size(), [&](std::size_t i) {
        if (stop.stop_requested() || shares[i].empty()) return;
        drawn[i] = draw(order[i], seed_of(seed, class_, order[i]), rounded, shares[i]);
    });
    if (stop.stop_requested()) return failure(ErrorCode::Stopped, "stopped before there was a result");
    for (const Result<void>& each : drawn) {
        if (!each) return tl::unexpected(each.error());
    }
    return all;
}

Result<void> DotGround::draw(std::uint32_t feature, std::uint64_t seed, const std::function<Point(Point)>& rounded,
                             std::span<FeatureDot> dots) const {
    constexpr int kAttempts = 16;  // if the feature covers half of the dots' cells, 1 dot of 65,536 is left unplaced
    constexpr int kClearAttempts = 8;
    const Domain& area = map_.features[feature].area;
    const auto density = density_of(feature);
    if (!density) return tl::unexpected(density.error());
    const Options options = start_options(feature, seed);
    const StartSites start(area, *density, options);
    std::optional<InteriorSampler> interior;
    for (std::size_t site = 0; site < options.sites; ++site) {
        std::optional<Point> position;
        for (int attempt = 0; attempt < kAttempts && !position; ++attempt) {
            const Point p = rounded(area.to_user(start.draw(site, attempt)));
            if (attempt < kClearAttempts ? allows_start(feature, p) : allows(feature, p)) position = p;
        }
        if (!position) {
            const auto accept = [&](Point p) {
                p = rounded(p);
                if (allows(feature, p)) position = p;
                return position.has_value();
            };
            if (auto drawn = draw_again(feature, seed + site, accept, interior); !drawn) return drawn;
        }
        dots[site] = {*position, feature};
    }
    return {};
}

Result<void> DotGround::draw_again(std::uint32_t feature, std::uint64_t seed, const std::function<bool(Point)>& accept,
                                   std::optional<InteriorSampler>& interior) const {
    constexpr int kAttempts = 1000;
    constexpr std::uint64_t kStream = 0x616e797768657265;
    const Domain& area = map_.features[feature].area;
    if (!interior) interior = interior_of(area);
    if (!interior) return too_thin(feature);
    Random random(seed, kStream);
    for (int attempt = 0; attempt < kAttempts; ++attempt) {
        if (accept(area.to_user(interior->draw(random)))) return {};
    }
    return too_thin(feature);
}

void DotGround::find_overlaps(std::span<const FeatureDot> dots, const std::stop_token& stop) {
    constexpr std::uint32_t kNone = ~std::uint32_t{0};
    std::uint32_t current = kNone;
    std::vector<std::uint32_t> known_to(overlaps_.size(), kNone);  // [features] last feature found to overlap
    for (const auto& [position, feature] : dots) {
        if (stop.stop_requested()) return;
        if (feature != current) {
            for (const std::uint32_t other : overlaps_[feature]) known_to[other] = feature;
            current = feature;
        }
        map_.index.for_near(position, [&, position = position, feature = feature](std::uint32_t other) {
            if (other == feature || known_to[other] == feature || this->dots(other) == 0) return;
            if (!map_.areas[other].contains(position)) return;
            known_to[other] = feature;
            overlaps_[feature].push_back(other);
            overlaps_[other].push_back(feature);
        });
    }
}

double DotGround::at(std::uint32_t feature, Point p) const {
    double density = own(feature, p);
    for (const std::uint32_t other : overlaps_[feature]) {
        if (map_.areas[other].contains(p)) density += own(other, p);
    }
    return density;
}

double DotGround::around(Point p) const {
    double density = 0;
    map_.index.for_near(p, [&](std::uint32_t feature) {
        if (dots(feature) > 0 && map_.areas[feature].contains(p)) density += own(feature, p);
    });
    return density;
}

bool DotGround::allows(std::uint32_t feature, Point p) const {
    return map_.areas[feature].contains(p) && (is_uniform() || density(p) > 0);
}

bool DotGround::allows_start(std::uint32_t feature, Point p) const {
    return fences_[feature].position_of(p) == FeatureArea::Position::Inside && (is_uniform() || density(p) > 0);
}

Point DotGround::towards(std::uint32_t feature, Point from, Point to) const {
    const Point there = fences_[feature].towards(from, to);
    return is_uniform() || density(there) > 0 ? there : from;
}

}  // namespace ccdt
