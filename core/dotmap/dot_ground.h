#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/ccdt/interior_sampler.h"
#include "core/density/density.h"
#include "core/dotmap/dot_map.h"
#include "core/dotmap/feature_area.h"
#include "core/dotmap/feature_index.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"
#include "core/parallel/team.h"
#include "core/result.h"

namespace ccdt {

/// A dot, and the feature that it belongs to for life.
struct FeatureDot {
    Point place;
    std::uint32_t feature = 0;
};

/// How densely the dots of one class are to lie in the features of a map, and where they may. All places are in the
/// caller's coordinates.
class DotGround {
public:
    /// What all classes of a map share; must outlive their grounds.
    struct Map {
        std::span<const MapFeature> features;
        std::span<const FeatureArea> areas;  ///< of the features
        const FeatureIndex& index;           ///< of the areas
        const Box& box;                      ///< that the density is stretched over
        const Density& density;
        std::span<const Point> fixed;  ///< points that are there already: dots get what they leave of a feature
    };

    /// Errors: Unusable if the density is zero all over a feature that has dots.
    /// @param stop  asked now and then: Error Stopped
    static Result<DotGround> create(const Map& map, std::size_t number, Team& team, const std::stop_token& stop);

    std::size_t features() const { return map_.features.size(); }
    const Domain& area(std::size_t feature) const { return map_.features[feature].area; }
    std::size_t dots() const { return dots_; }
    std::size_t dots(std::size_t feature) const { return map_.features[feature].dots[class_]; }
    bool is_uniform() const { return map_.density.is_uniform(); }
    bool is_smooth() const { return map_.density.is_smooth(); }

    /// Dots to a squared unit that a feature has, with the room of fixed points counted for dots, where the density
    /// is 1.
    double weight(std::size_t feature) const { return wanted_[feature]; }

    /// What the ground wants, as the density has it.
    double density(Point p) const;

    /// Draws the first dots: of each feature a few in each of many cells that want as many, at random. Features come in
    /// an order in which neighbours follow each other, mostly.
    /// @param rounded  takes a place to where it will be, by rounding; called by several at the same time
    /// Errors: Unusable for a feature that is too thin; Stopped.
    Result<std::vector<FeatureDot>> draw(std::uint64_t seed, const std::function<Point(Point)>& rounded, Team& team,
                                         const std::stop_token& stop) const;

    /// Draws a dot anew, anywhere in its feature, until it is accepted. Errors: Unusable.
    /// @param interior  of the feature; made if it is not there yet
    Result<void> draw_again(std::uint32_t feature, std::uint64_t seed, const std::function<bool(Point)>& accept,
                            std::optional<InteriorSampler>& interior) const;

    /// Finds out which features overlap, from where dots are.
    /// @param stop  asked now and then; some are not found, then
    void find_overlaps(std::span<const FeatureDot> dots, const std::stop_token& stop);

    /// Dots to a squared unit at a place of a feature, those of others that overlap with it there included.
    double at(std::uint32_t feature, Point p) const;

    /// The same at any place, of all features there.
    double around(Point p) const;

    /// Tells whether the density is the same all over a feature.
    bool is_even(std::uint32_t feature) const { return is_uniform() && overlaps_[feature].empty(); }

    /// Tells whether a dot may be at a place.
    bool may_be(std::uint32_t feature, Point p) const;

    /// Tells whether a dot may begin at a place: so far from ground with fewer dots as its row should be.
    bool is_clear(std::uint32_t feature, Point p) const;

    /// Tells of most places where is_clear() that it is so, at once.
    bool is_deep(std::uint32_t feature, Point p) const { return is_uniform() && fences_[feature].is_deep(p); }

    /// Where a dot gets that is to go from one place to another.
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
    std::vector<FeatureArea> fences_;                   ///< [features] with the clearance of these dots
    std::vector<double> wanted_;                        ///< [features] dots to a squared unit where the density is 1
    std::vector<std::vector<Point>> fixed_;             ///< [features] that lie in it; empty if there are none in any
    std::vector<std::vector<std::uint32_t>> overlaps_;  ///< [features] others of which a part lies in it
};

}  // namespace ccdt
