// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/base/executor.h"
#include "core/base/result.h"
#include "core/ccdt/maps/feature_area.h"
#include "core/ccdt/maps/feature_index.h"
#include "core/ccdt/maps/map_feature.h"
#include "core/ccdt/plane/interior_sampler.h"
#include "core/density/density.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"

namespace ccdt {

/// A dot, and the feature in which it must stay.
struct FeatureDot {
    Point position;
    std::uint32_t feature = 0;
};

/// Wanted density of the dots of one class in the features of a map, and the area where these dots may lie. Positions
/// are in the caller's coordinates.
class DotGround {
public:
    /// Data that all classes of a map share. The referenced data must outlive the DotGround of every class.
    struct Map {
        std::span<const MapFeature> features;
        std::span<const FeatureArea> areas;  ///< areas of the features
        const FeatureIndex& index;           ///< index of the areas
        const Box& box;                      ///< box over which the density is stretched
        const Density& density;
        std::span<const Point> fixed;  ///< existing points; dots take the remaining area of a feature
    };

    /// Creates the DotGround of one class.
    /// @param number  number of the class
    /// @param stop    polled regularly; a stop gives the error Stopped
    ///
    /// Errors: Unusable if the density is zero everywhere in a feature that has dots.
    static Result<DotGround> create(const Map& map, std::size_t number, Executor& executor,
                                    const std::stop_token& stop);

    std::size_t features() const { return map_.features.size(); }
    const Domain& area(std::size_t feature) const { return map_.features[feature].area; }
    std::size_t dots() const { return dots_; }
    std::size_t dots(std::size_t feature) const { return map_.features[feature].dots[class_]; }
    bool is_uniform() const { return map_.density.is_uniform(); }
    bool is_smooth() const { return map_.density.is_smooth(); }

    /// Returns a feature's wanted dots per squared unit where the density is 1. The area that fixed points take does
    /// not count.
    double weight(std::size_t feature) const { return wanted_[feature]; }

    /// Returns the wanted density at a point, according to the map's density.
    double density(Point p) const;

    /// Draws the initial dots. Divides each feature into many cells of equal capacity, and draws a few random positions
    /// in each cell. The result is grouped by feature, and successive features are mostly neighbours.
    /// @param rounded  rounds a position to the precision of the mesh; called in parallel
    ///
    /// Errors: Unusable for a feature that is too thin; Stopped.
    Result<std::vector<FeatureDot>> draw(std::uint64_t seed, const std::function<Point(Point)>& rounded,
                                         Executor& executor, const std::stop_token& stop) const;

    /// Draws random positions anywhere in a feature until `accept` returns true for one of them. Errors: Unusable if
    /// the feature is too thin, or if none of a limited number of positions is accepted.
    /// @param interior  sampler of the feature; created here if empty
    Result<void> draw_again(std::uint32_t feature, std::uint64_t seed, const std::function<bool(Point)>& accept,
                            std::optional<InteriorSampler>& interior) const;

    /// Finds the pairs of features that overlap. A pair counts if a dot of one feature lies in the other feature.
    /// @param stop  polled regularly; after a stop some overlaps may be missing
    void find_overlaps(std::span<const FeatureDot> dots, const std::stop_token& stop);

    /// Returns the wanted dots per squared unit at a position in a feature, including those of overlapping features.
    double at(std::uint32_t feature, Point p) const;

    /// Returns the wanted dots per squared unit at any position, summed over all features there.
    double around(Point p) const;

    /// Whether the density is constant over a feature.
    bool is_uniform_in(std::uint32_t feature) const { return is_uniform() && overlaps_[feature].empty(); }

    /// Whether a position is inside a feature and has a positive density.
    bool allows(std::uint32_t feature, Point p) const;

    /// Whether a dot may start at a position: allows() is true, and no much sparser feature is close.
    bool allows_start(std::uint32_t feature, Point p) const;

    /// Tests quickly whether allows_start() is true. Returns false in uncertain cases.
    bool is_far_inside(std::uint32_t feature, Point p) const {
        return is_uniform() && fences_[feature].is_far_inside(p);
    }

    /// Moves a dot from one position towards another, without leaving the feature. Returns the end of the move.
    Point towards(std::uint32_t feature, Point from, Point to) const;

private:
    DotGround(const Map& map, std::size_t number) : map_(map), class_(number) {}

    FeatureArea make_fence(std::uint32_t feature) const;
    void find_fixed();
    Result<Density> density_of(std::uint32_t feature) const;
    Options start_options(std::uint32_t feature, std::uint64_t seed) const;
    double own(std::uint32_t feature, Point p) const { return wanted_[feature] * density(p); }
    Result<Density> cut_out(const Domain& area, double& largest) const;
    std::vector<std::uint32_t> order() const;
    Result<void> draw(std::uint32_t feature, std::uint64_t seed, const std::function<Point(Point)>& rounded,
                      std::span<FeatureDot> dots) const;

    Map map_;
    std::size_t class_;
    std::size_t dots_ = 0;
    std::vector<FeatureArea> fences_;  ///< [features] areas, with clearances from sparser features
    std::vector<double> wanted_;       ///< [features] dots per squared unit where the density is 1
    /// [features] fixed points in each feature; empty if there are no fixed points.
    std::vector<std::vector<Point>> fixed_;
    std::vector<std::vector<std::uint32_t>> overlaps_;  ///< [features] the other features that overlap each feature
};

}  // namespace ccdt
