// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/field/spot_function.h"

#include <array>
#include <cmath>
#include <cstddef>

#include "core/base/elementary.h"
#include "core/geometry/point.h"

namespace ccdt {

namespace {

// A sixth of an equilateral triangle of side 1: a corner at the origin, the middle of an edge, and the centroid.
const double kHeight = 1 / (2 * std::sqrt(3.0));
const Point kMiddle{0.5, 0}, kCentroid{0.5, kHeight};
const double kArea = kHeight / 4;

// Dots become round below the first share of ink, and holes below the second share of paper.
constexpr double kRoundDots = 0.57, kRoundHoles = 0.4;

constexpr std::size_t kRays = 64;

/// Distances from a centre to a contour along rays that cross a side of the sixth.
struct Contour {
    std::array<Point, kRays + 1> directions;  ///< of length 1
    std::array<double, kRays + 1> distances{};

    /// Returns the area within a contour with other distances, divided by the area of the sixth.
    /// @param distance_at  returns the new distance for a distance of this contour
    template <class Function>
    double share(const Function& distance_at) const {
        double twice = 0;
        for (std::size_t i = 0; i < kRays; ++i) {
            const Point u = directions[i], v = directions[i + 1];
            twice += std::abs(u.x * v.y - u.y * v.x) * distance_at(distances[i]) * distance_at(distances[i + 1]);
        }
        return twice / 2 / kArea;
    }
    double share() const {
        return share([](double distance) { return distance; });
    }
};

double length(Point p) {
    return elementary::hypot(p.x, p.y);
}

/// Returns rays from a centre to positions along a side; the distances are 0.
Contour rays(Point centre, Point from, Point to) {
    Contour contour;
    for (std::size_t i = 0; i <= kRays; ++i) {
        const double share = static_cast<double>(i) / kRays;
        const Point ray = from + share * (to - from) - centre;
        contour.directions[i] = 1 / length(ray) * ray;
    }
    return contour;
}

/// Returns the distance from `centre`, along a ray, to the position whose distance to `other` is `ratio` times its
/// distance to `centre`: a circle of Apollonius.
double distance_to(Point centre, Point other, Point direction, double ratio) {
    const Point between = other - centre;
    const double along = between.x * direction.x + between.y * direction.y;
    const double squared = between.x * between.x + between.y * between.y;
    return squared / (along + std::sqrt(along * along + squared * (ratio * ratio - 1)));
}

/// Returns the contour around the corner on which the distance to the centroid is `ratio` times that to the corner.
Contour around_corner(double ratio) {
    Contour contour = rays({0, 0}, kMiddle, kCentroid);
    for (std::size_t i = 0; i <= kRays; ++i)
        contour.distances[i] = distance_to({0, 0}, kCentroid, contour.directions[i], ratio);
    return contour;
}

/// Returns the same contour, given by rays from the centroid.
Contour around_centroid(double ratio) {
    Contour contour = rays(kCentroid, {0, 0}, kMiddle);
    for (std::size_t i = 0; i <= kRays; ++i)
        contour.distances[i] = distance_to(kCentroid, {0, 0}, contour.directions[i], 1 / ratio);
    return contour;
}

/// Returns the ratio of distances at which the contour encloses a share of the sixth.
double ratio_of(double share) {
    double low = 0.55, high = 4;
    for (int i = 0; i < 60; ++i) {
        const double middle = (low + high) / 2;
        (around_corner(middle).share() > share ? low : high) = middle;
    }
    return (low + high) / 2;
}

/// Contours that become circles towards their centre.
class Rounded {
public:
    Rounded(Point centre, const Contour& outer) : centre_(centre) {
        double angle = 0, squares = 0;
        for (std::size_t i = 0; i < kRays; ++i) {
            const Point u = outer.directions[i], v = outer.directions[i + 1];
            const double step = std::abs(u.x * v.y - u.y * v.x);
            angle += step;
            squares += step * outer.distances[i] * outer.distances[i + 1];
        }
        mean_ = std::sqrt(squares / angle);
        for (std::size_t i = 0; i <= kScales; ++i) {
            const double scale = static_cast<double>(i) / kScales;
            shares_[i] = outer.share([&](double edge) {
                return scale * mean_ * elementary::pow(edge / mean_, elementary::pow(scale, kRoundness));
            });
        }
    }

    /// Returns the share of the sixth that the contour through a position encloses.
    /// @param edge  distance from the centre to the outermost contour in the direction of the position
    double share(Point position, double edge) const {
        // Solves log(scale) + scale^kRoundness log(edge / mean) = log(distance / mean) by Newton's method.
        constexpr int kSteps = 8;
        const double bulge = elementary::log(edge / mean_),
                     wanted = elementary::log(length(position - centre_) / mean_);
        double scale = std::min(length(position - centre_) / mean_, 1.0);
        for (int i = 0; i < kSteps; ++i)
            scale -= (elementary::log(scale) + elementary::pow(scale, kRoundness) * bulge - wanted) /
                     (1 / scale + kRoundness * elementary::pow(scale, kRoundness - 1) * bulge);
        const double at = std::clamp(scale, 0.0, 1.0) * kScales;
        const auto below = std::min(static_cast<std::size_t>(at), kScales - 1);
        return shares_[below] + (at - static_cast<double>(below)) * (shares_[below + 1] - shares_[below]);
    }

private:
    static constexpr std::size_t kScales = 256;
    static constexpr int kRoundness = 4;  // how quickly contours become circles

    Point centre_;
    double mean_ = 0;                           ///< distance of the outermost contour
    std::array<double, kScales + 1> shares_{};  ///< share within the contours at steps of the scale
};

/// The spot function at positions in the sixth.
class Values {
public:
    double at(Point position) const {
        const double corner = length(position), centre = length(position - kCentroid);
        if (centre >= dot_ * corner) {
            if (corner == 0) return 1;
            return 1 - dots_.share(position, distance_to({0, 0}, kCentroid, 1 / corner * position, dot_));
        }
        if (centre <= hole_ * corner) {
            if (centre == 0) return 0;
            const Point ray = 1 / centre * (position - kCentroid);
            return holes_.share(position, distance_to(kCentroid, {0, 0}, ray, 1 / hole_));
        }
        return 1 - around_corner(centre / corner).share();
    }

private:
    double dot_ = ratio_of(kRoundDots), hole_ = ratio_of(1 - kRoundHoles);
    Rounded dots_{{0, 0}, around_corner(dot_)};
    Rounded holes_{kCentroid, around_centroid(hole_)};
};

}  // namespace

SpotFunction::SpotFunction() : values_((kSteps + 1) * (kSteps + 1)) {
    const Values values;
    for (std::size_t row = 0; row <= kSteps; ++row) {
        for (std::size_t column = 0; row + column <= kSteps; ++column) {
            const double along = static_cast<double>(column) / kSteps, inside = static_cast<double>(row) / kSteps;
            values_[row * (kSteps + 1) + column] = static_cast<float>(values.at(along * kMiddle + inside * kCentroid));
        }
    }
}

}  // namespace ccdt
