#include "core/order/progressive_order.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numbers>
#include <numeric>
#include <optional>
#include <queue>
#include <utility>

#include "core/geometry/hexagonal_spacing.h"
#include "core/globe/chart.h"
#include "core/polish/cell_list.h"

namespace ccdt {

namespace {

constexpr std::size_t kStopStride = 1'024;  ///< points between two looks at the stop token

// Test ProgressiveOrder holds these to what they reach. A shorter reach keeps the
// nearest further apart and leaves more power in low frequencies, a longer one does the opposite and takes longer.
constexpr double kReach = 1.7;  ///< over the distance of neighbours in a hexagonal grid
constexpr double kStep = 0.7;   ///< share of the points that is left when reaches grow

/// Points that a region has yet, at the least. Fewer leave too little to choose from, and lose distance; of more, waves
/// longer than a few of their spacings are no longer in balance.
constexpr std::size_t kLeastCrowd = 16;

/// Neighbours whose distance tells how dense points are: enough for a measure that hardly wavers, few enough to be
/// near.
constexpr std::size_t kNeighbours = 12;

double squared_length(Point p) {
    return dot(p, p);
}

/// Crowding by a neighbour at a share of the reach.
double crowding(double share) {
    const double left = 1 - share, squared = left * left, fourth = squared * squared;
    return fourth * fourth;
}

/// Reach of two points that have their own, over the shorter of them at the most.
constexpr double kMostReach = 1.3;

/// A mean, lest where two densities meet the denser or the sparser side lose more than its share.
double common_reach(double a, double b) {
    return a == b ? a : std::min(std::sqrt(a * b), kMostReach * std::min(a, b));
}

/// Spacing of points around each, 1 / sqrt(density), by the distance of its nearest ones.
class SpacingMeter {
public:
    /// @param usual  spacing, were points as dense everywhere
    SpacingMeter(const Domain& domain, std::span<const Point> places, double usual)
        : places_(places),
          near_(domain, places),
          usual_(usual),
          widest_(2 * (domain.unit_bounds().width() + domain.unit_bounds().height())) {}

    double operator()(std::uint32_t point) {
        const std::size_t wanted = std::min(kNeighbours, places_.size() - 1);
        double reach = 2.2 * usual_;  // a little further than so many are usually
        while (!find(point, reach, wanted) && reach < widest_) reach *= 2;
        if (squares_.size() < wanted || wanted == 0) return usual_;
        const auto last = squares_.begin() + static_cast<std::ptrdiff_t>(wanted) - 1;
        std::ranges::nth_element(squares_, last);
        // Places that coincide have no spacing, but want one that can be divided by.
        constexpr double kLeast = 1e-9;
        return std::max(std::sqrt(*last * std::numbers::pi / static_cast<double>(wanted)), kLeast * usual_);
    }

private:
    /// Tells whether there are enough neighbours within reach.
    bool find(std::uint32_t point, double reach, std::size_t wanted) {
        squares_.clear();
        near_.for_near(places_[point], reach, [&](Point place, std::uint32_t number) {
            const double square = squared_length(place - places_[point]);
            if (number != point && square < reach * reach) squares_.push_back(square);
        });
        return squares_.size() >= wanted;
    }

    std::span<const Point> places_;
    CellList near_;
    double usual_;
    double widest_;  ///< reach from which on all there are have been found
    std::vector<double> squares_;
};

/// Regions of about equally many points each, halved again and again, that lose points in turn.
class Regions {
public:
    /// Sorts points by region.
    /// @param order  of the points: made so that those of each region follow each other
    Regions(std::span<const Point> places, std::vector<std::uint32_t>& order) {
        while ((order.size() >> depth_) >= 2 * kLeastCrowd) ++depth_;
        sizes_.resize(std::size_t{2} << depth_);
        divide(places, order, 1, 0);
        left_ = sizes_;
    }

    /// Depth at which regions hold enough points to choose from.
    int depth(std::size_t left) const {
        int depth = 0;
        while (depth < depth_ && (left >> (depth + 1)) >= kLeastCrowd) ++depth;
        return depth;
    }

    /// Points left in each region of a depth.
    std::span<const std::uint32_t> left(int depth) const {
        const std::size_t count = std::size_t{1} << depth;
        return std::span(left_).subspan(count, count);
    }

    /// Takes a point from the region of a depth whose turn it is: of each two the one that has more of its points yet.
    std::size_t take(int depth) {
        std::size_t region = 1;
        --left_[region];
        for (int i = 0; i < depth; ++i) {
            const std::size_t first = 2 * region, second = first + 1;
            const std::uint64_t a = std::uint64_t{left_[first]} * sizes_[second];
            const std::uint64_t b = std::uint64_t{left_[second]} * sizes_[first];
            region = a > b || (a == b && is_first(region)) ? first : second;
            --left_[region];
        }
        return region - (std::size_t{1} << depth);
    }

private:
    /// Tosses a coin between two halves, lest the first ones of all regions have less than the second ones.
    bool is_first(std::size_t region) const {
        std::uint64_t bits = (region << 32 | left_[region]) * 0x9e3779b97f4a7c15;
        bits = (bits ^ bits >> 32) * 0xd6e8feb86659fd93;
        return (bits >> 63) != 0;
    }

    void divide(std::span<const Point> places, std::span<std::uint32_t> order, std::size_t region, int depth) {
        sizes_[region] = static_cast<std::uint32_t>(order.size());
        if (depth == depth_) return;
        Box box{places[order[0]], places[order[0]]};
        for (const std::uint32_t i : order) box.include(places[i]);
        const auto along = [&](std::uint32_t i) { return box.width() > box.height() ? places[i].x : places[i].y; };
        const std::size_t half = order.size() / 2;
        std::ranges::nth_element(
            order, order.begin() + static_cast<std::ptrdiff_t>(half),
            [&](std::uint32_t i, std::uint32_t j) { return std::pair(along(i), i) < std::pair(along(j), j); });
        divide(places, order.first(half), 2 * region, depth + 1);
        divide(places, order.subspan(half), 2 * region + 1, depth + 1);
    }

    int depth_ = 0;
    std::vector<std::uint32_t> sizes_;  ///< [2 << depth] of the two halves of region i, 2 i and 2 i + 1
    std::vector<std::uint32_t> left_;
};

/// Takes points away, a step after the other, in which reaches stay the same.
class Elimination {
public:
    /// @param even  all spacings are the same
    Elimination(const Domain& domain, std::vector<Point> places, std::vector<double> spacings, bool even,
                Regions regions)
        : domain_(domain),
          places_(std::move(places)),
          spacings_(std::move(spacings)),
          widest_(even ? 1 : kMostReach),
          regions_(std::move(regions)),
          left_(places_.size()) {
        std::iota(left_.begin(), left_.end(), 0U);
    }

    /// Takes a step. @returns the points that went, the first one first
    std::vector<std::uint32_t> step(const std::stop_token& stop) {
        const std::size_t target = static_cast<std::size_t>(static_cast<double>(left_.size()) * kStep);
        set_neighbours(target);
        crowd(stop);
        const int depth = regions_.depth(left_.size());
        std::vector<std::uint32_t> begins = {0};
        for (const std::uint32_t count : regions_.left(depth)) begins.push_back(begins.back() + count);
        std::vector<std::uint32_t> gone;
        gone.reserve(left_.size() - target);
        while (gone.size() < left_.size() - target) {
            if (gone.size() % kStopStride == 0 && stop.stop_requested()) break;
            const std::size_t region = regions_.take(depth);
            const std::uint32_t i = most_crowded(begins[region], begins[region + 1]);
            remove(i);
            gone.push_back(left_[i]);
        }
        keep_rest();
        return gone;
    }

    const std::vector<std::uint32_t>& left() const { return left_; }

private:
    void set_neighbours(std::size_t target) {
        const double share = std::max(static_cast<double>(target), 1.0) / static_cast<double>(places_.size());
        const double reach = kReach * hexagonal_spacing(share);
        near_places_.clear();
        reaches_.clear();
        for (const std::uint32_t i : left_) {
            near_places_.push_back(places_[i]);
            reaches_.push_back(reach * spacings_[i]);
        }
        near_.emplace(domain_, near_places_);
        crowding_.assign(left_.size(), 0);
        is_there_.assign(left_.size(), 1);
    }

    /// Calls function(j, crowding) with each neighbour j that is still there, of those left.
    template <class Function>
    void for_neighbours(std::uint32_t i, Function&& function) const {
        const Point here = near_places_[i];
        near_->for_near(here, widest_ * reaches_[i], [&](Point place, std::uint32_t j) {
            if (j == i || is_there_[j] == 0) return;
            const double square = squared_length(place - here), reach = common_reach(reaches_[i], reaches_[j]);
            if (square < reach * reach) function(j, crowding(std::sqrt(square) / reach));
        });
    }

    void crowd(const std::stop_token& stop) {
        for (std::uint32_t i = 0; i < left_.size(); ++i) {
            if (i % kStopStride == 0 && stop.stop_requested()) break;
            for_neighbours(i, [&](std::uint32_t, double crowding) { crowding_[i] += crowding; });
        }
    }

    std::uint32_t most_crowded(std::uint32_t begin, std::uint32_t end) const {
        std::uint32_t most = end;
        for (std::uint32_t i = begin; i < end; ++i) {
            if (is_there_[i] != 0 && (most == end || crowding_[i] > crowding_[most])) most = i;
        }
        return most;
    }

    void remove(std::uint32_t i) {
        is_there_[i] = 0;
        for_neighbours(i, [&](std::uint32_t j, double crowding) { crowding_[j] -= crowding; });
    }

    void keep_rest() {
        std::size_t kept = 0;
        for (std::size_t i = 0; i < left_.size(); ++i) {
            if (is_there_[i] != 0) left_[kept++] = left_[i];
        }
        left_.resize(kept);
    }

    const Domain& domain_;
    std::vector<Point> places_;     ///< [n] in the unit frame
    std::vector<double> spacings_;  ///< [n]
    double widest_;                 ///< reach of a point and another one, over its own
    Regions regions_;
    std::vector<std::uint32_t> left_;

    // Of those left when the step began.
    std::vector<Point> near_places_;
    std::vector<double> reaches_;
    std::optional<CellList> near_;
    std::vector<double> crowding_;
    std::vector<std::uint8_t> is_there_;
};

/// @param even  points are as dense everywhere
/// @returns     spacing around each
std::vector<double> spacings_of(const Domain& domain, std::span<const Point> places, bool even,
                                const std::stop_token& stop) {
    const double usual = std::sqrt(domain.unit_area() / static_cast<double>(places.size()));
    std::vector<double> spacings(places.size(), usual);
    if (even) return spacings;
    SpacingMeter meter(domain, places, usual);
    for (std::uint32_t i = 0; i < places.size(); ++i) {
        if (i % kStopStride == 0 && stop.stop_requested()) break;
        spacings[i] = meter(i);
    }
    return spacings;
}

/// Keeps points opposite the chart's centre from lying at infinity.
double clamped(double coordinate) {
    constexpr double kFarthest = 1'000;  // a circle of 13 km around there
    return std::clamp(coordinate, -kFarthest, kFarthest);
}

/// Makes a sum that would be 0, of points all over the globe, a direction.
constexpr double kTilt = 1e-6;

constexpr double kLeastSide = 1e-9;  ///< of a chart's square, should all points coincide

/// Orders points of the unit frame.
std::vector<std::uint32_t> order_places(const Domain& domain, std::span<const Point> unsorted, bool even,
                                        const std::stop_token& stop) {
    std::vector<std::uint32_t> order;
    if (unsorted.empty()) return order;
    std::vector<std::uint32_t> numbers(unsorted.size());
    std::iota(numbers.begin(), numbers.end(), 0U);
    Regions regions(unsorted, numbers);
    std::vector<Point> places;
    places.reserve(unsorted.size());
    for (const std::uint32_t i : numbers) places.push_back(unsorted[i]);
    std::vector<double> spacings = spacings_of(domain, places, even, stop);

    Elimination elimination(domain, std::move(places), std::move(spacings), even, std::move(regions));
    while (elimination.left().size() > 1 && !stop.stop_requested()) {
        const std::vector<std::uint32_t> gone = elimination.step(stop);
        order.insert(order.end(), gone.begin(), gone.end());
    }
    order.insert(order.end(), elimination.left().begin(), elimination.left().end());
    std::ranges::reverse(order);
    for (std::uint32_t& each : order) each = numbers[each];
    return order;
}

}  // namespace

std::vector<std::uint32_t> progressive_order(const Domain& domain, std::span<const Point> points, bool even,
                                             const std::stop_token& stop) {
    std::vector<Point> places;
    places.reserve(points.size());
    for (const Point p : points) places.push_back(domain.to_unit(p));
    return order_places(domain, places, even, stop);
}

std::vector<std::uint32_t> progressive_order_on_globe(std::span<const Point> points, const std::stop_token& stop) {
    if (points.empty()) return {};
    std::vector<Direction> directions;
    directions.reserve(points.size());
    Direction sum{0, 0, kTilt};
    for (const Point p : points) {
        directions.push_back(direction_of(p));
        sum = sum + directions.back();
    }
    const Chart chart(normalised(sum));
    std::vector<Point> places;
    places.reserve(points.size());
    for (const Direction d : directions) {
        const Point p = chart.to_plane(d);
        places.push_back({clamped(p.x), clamped(p.y)});
    }
    Box box{places.front(), places.front()};
    for (const Point p : places) box.include(p);
    const double side = std::max({box.width(), box.height(), kLeastSide});
    const Domain square = Domain::rectangle(side, side).value();
    for (Point& p : places) p = square.to_unit(p - box.min);
    return order_places(square, places, false, stop);
}

}  // namespace ccdt
