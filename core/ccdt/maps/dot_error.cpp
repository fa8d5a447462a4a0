// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/maps/dot_error.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "core/base/elementary.h"

namespace ccdt {

namespace {

constexpr long kNone = std::numeric_limits<long>::min();

bool is_near(long octave, long other) {
    return octave != kNone && std::abs(octave - other) <= 1;
}

/// Converts features to the unit frame of the land, which is the union of all features with dots.
class UnitMap {
public:
    UnitMap(const DotGround& ground, const Domain& land)
        : ground_(ground), corner_(land.bounds().min), side_(std::max(land.bounds().width(), land.bounds().height())) {}

    /// Returns the octave of the spacing of each feature's dots; kNone for a feature without dots.
    std::vector<long> octaves() const {
        std::vector<long> octaves;
        for (std::size_t feature = 0; feature < ground_.features(); ++feature) {
            const auto dots = static_cast<double>(ground_.dots(feature));
            octaves.push_back(dots > 0 ? std::lround(elementary::log2(area(feature) / dots) / 2) : kNone);
        }
        return octaves;
    }

    /// Returns the bounding box of features that have dots.
    /// @param features  at least one
    Box bounds(std::span<const std::size_t> features) const {
        const auto bounds_of = [this](std::size_t feature) { return ground_.area(feature).bounds(); };
        Box box = bounds_of(features.front());
        for (const std::size_t feature : features) {
            box.include(bounds_of(feature).min);
            box.include(bounds_of(feature).max);
        }
        return {to_unit(box.min), to_unit(box.max)};
    }

    /// Creates the grid of an octave.
    /// @param box       bounding box of all of `features`
    /// @param features  the octave's own features and those of the adjacent octaves
    /// @param own       the octave's own features, at least one
    ErrorGrid make_grid(const Box& box, std::span<const std::size_t> features, std::span<const std::size_t> own) const {
        constexpr double kMaxCells = 8;  // per dot; features of an octave may lie far apart
        double area = 0;
        std::size_t dots = 0, own_dots = 0;
        std::vector<BorderEdge> border;
        for (const std::size_t feature : features) {
            add_border(feature, box.min, border);
            dots += ground_.dots(feature);
        }
        for (const std::size_t feature : own) {
            area += this->area(feature);
            own_dots += ground_.dots(feature);
        }
        const double least = std::sqrt(box.width() * box.height() / (kMaxCells * static_cast<double>(dots)));
        const double cell = std::max(std::sqrt(area / static_cast<double>(own_dots)), least);
        return {{box.width(), box.height()}, cell, dots, border, density_over(box, cell)};
    }

private:
    Point to_unit(Point user) const { return 1 / side_ * (user - corner_); }
    Point to_user(Point unit) const { return corner_ + side_ * unit; }
    double area(std::size_t feature) const { return ground_.area(feature).area() / side_ / side_; }

    /// Adds the edges of a feature's border, with the weight DotGround::weight().
    /// @param corner  origin of the edges' coordinates, in the unit frame of the land
    void add_border(std::size_t feature, Point corner, std::vector<BorderEdge>& border) const {
        const Domain& area = ground_.area(feature);
        const auto position = [&](Point p) { return to_unit(area.to_user(p)) - corner; };
        for (const Ring& ring : area.rings()) {
            for (std::size_t i = 0; i < ring.size(); ++i)
                border.push_back({position(ring[i]), position(ring[(i + 1) % ring.size()]), ground_.weight(feature)});
        }
    }

    /// Samples the map's density over a box, at the centres of cells.
    Density density_over(const Box& box, double cell) const {
        if (ground_.is_uniform()) return Density::uniform();
        constexpr double kMax = 1024;
        const auto cells = [&](double side) { return std::clamp(std::ceil(side / cell), 1.0, kMax); };
        const double columns = cells(box.width()), rows = cells(box.height());
        std::vector<double> values;
        for (double row = 0.5; row < rows; ++row) {
            for (double column = 0.5; column < columns; ++column) {
                const Point middle{column / columns * box.width(), row / rows * box.height()};
                values.push_back(ground_.density(to_user(box.min + middle)));
            }
        }
        return Density::grid(static_cast<int>(columns), static_cast<int>(rows), std::span<const double>(values))
            .value_or(Density::uniform());
    }

    const DotGround& ground_;
    Point corner_;
    double side_;
};

}  // namespace

DotError::DotError(const DotGround& ground, const Domain& land, std::span<const FeatureDot> dots) {
    const UnitMap map(ground, land);
    const std::vector<long> octave_of = map.octaves();
    std::vector<long> octaves = octave_of;
    std::ranges::sort(octaves);
    octaves.erase(std::unique(octaves.begin(), octaves.end()), octaves.end());
    for (const long octave : octaves) {
        if (octave == kNone) continue;
        std::vector<std::size_t> features, own;
        for (std::size_t feature = 0; feature < octave_of.size(); ++feature) {
            if (is_near(octave_of[feature], octave)) features.push_back(feature);
            if (octave_of[feature] == octave) own.push_back(feature);
        }
        const Box box = map.bounds(features);
        Octave& made = octaves_.emplace_back(Octave{map.make_grid(box, features, own), box, {}, {}});
        for (std::uint32_t dot = 0; dot < dots.size(); ++dot) {
            const long other = octave_of[dots[dot].feature];
            if (is_near(other, octave)) (other == octave ? made.own : made.others).push_back(dot);
        }
    }
}

void DotError::measure(std::span<const Point> positions, std::span<double> errors) {
    for (auto& [grid, box, own, others] : octaves_) {
        const auto position = [&, &box = box](std::uint32_t dot) {
            return Point{std::clamp(positions[dot].x - box.min.x, 0.0, box.width()),
                         std::clamp(positions[dot].y - box.min.y, 0.0, box.height())};
        };
        positions_.clear();
        for (const std::uint32_t dot : own) positions_.push_back(position(dot));
        for (const std::uint32_t dot : others) positions_.push_back(position(dot));
        grid.measure(positions_);
        for (std::size_t i = 0; i < own.size(); ++i) errors[own[i]] = grid.at(positions_[i]);
    }
}

}  // namespace ccdt
