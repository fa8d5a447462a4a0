#include "core/order/progressive_order.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>
#include <tuple>
#include <utility>

#include "core/geometry/hexagonal_spacing.h"
#include "core/geometry/lanes.h"
#include "core/globe/chart.h"
#include "core/polish/cell_list.h"

namespace ccdt {

namespace {

constexpr std::size_t kStopStride = 1'024;  ///< points between two looks at the stop token

// Benchmarks ProgressivePattern and ProgressiveTone show what these reach, test ProgressiveOrder holds them to it. A
// shorter reach keeps neighbours further apart and leaves more power in low frequencies, a longer one does the opposite
// and takes longer.
constexpr double kReach = 1.7;  ///< over the distance of neighbours in a hexagonal grid
constexpr double kStep = 0.7;   ///< share of the points that is left when reaches grow

/// Distance that no two points that stay have less of, over that of neighbours in a hexagonal grid. A third of a
/// hexagonal grid, the most that are no neighbours in it, is followed by points at 0.577: a greater distance forces the
/// choice of half the points there are around a third, and leaves more power.
constexpr double kLeastDistance = 0.58;

/// Weight of the surplus around a point beside its crowding. A greater one leaves less power in long waves, and more in
/// those of two or three spacings.
constexpr float kSurplusWeight = 0.5F;

/// Distance of the nodes between which surplus is blurred, over that of neighbours in a hexagonal grid.
constexpr double kNodeDistance = 3;

/// Points over those that are left whose density is still taken for that of all.
constexpr std::size_t kManyTimes = 8;

/// Points that a region has yet, at the least. Fewer leave too little to choose from, and more noise; more take longer.
constexpr std::size_t kLeastCrowd = 256;

/// Neighbours whose distance tells how dense points are: enough for a measure that hardly wavers, few enough to be
/// near.
constexpr std::size_t kNeighbours = 12;

double squared_length(Point p) {
    return dot(p, p);
}

/// Crowding by a neighbour at a share of the reach, (1 - share)^5, is (1 - share^2)^5 times a polynomial of 1 -
/// share^2: within 7 % from a third to nine tenths of it.
constexpr std::array<float, 5> kCrowding = {0.12919328F, -0.9645656F, 3.58161193F, -5.21164568F, 2.87339624F};

/// Reach of two points that have their own, over the shorter of them at the most. It is their geometric mean, lest
/// where two densities meet the denser or the sparser side lose more than its share.
constexpr double kMostReach = 1.3;
constexpr float kMostSquare = static_cast<float>(1 / (kMostReach * kMostReach));

/// Spacing of points around each, 1 / sqrt(density), by the distance of its nearest ones.
class SpacingMeter {
public:
    /// @param usual  spacing, were points as dense everywhere
    SpacingMeter(const Domain& domain, std::span<const Point> places, const CellList& near, double usual)
        : places_(places),
          near_(near),
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
    const CellList& near_;
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

    /// Region of a depth whose turn it is: of each two the one that has more of its points yet.
    std::size_t turn(int depth) const {
        std::size_t region = 1;
        for (int i = 0; i < depth; ++i) {
            const std::size_t first = 2 * region, second = first + 1;
            const std::uint64_t a = std::uint64_t{left_[first]} * sizes_[second];
            const std::uint64_t b = std::uint64_t{left_[second]} * sizes_[first];
            region = a > b || (a == b && is_first(region)) ? first : second;
        }
        return region - (std::size_t{1} << depth);
    }

    /// Takes a point from a region of a depth, be it its turn or not.
    void take(int depth, std::size_t region) {
        for (region += std::size_t{1} << depth; region > 0; region /= 2) --left_[region];
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

/// Tells how many points there are around one beyond their share: what there are less what there should be, blurred by
/// quadratic B-splines to nodes of a square grid and back. It holds long waves down, which neighbours do not tell of.
class Surplus {
public:
    /// @param reference  points as dense everywhere as those that there are should be, over a common factor
    /// @param points     that there are, numbered from 0
    /// @param distance   of nodes
    Surplus(const Domain& domain, std::span<const Point> reference, std::span<const Point> points, double distance)
        : x_(domain.unit_bounds().width(), distance, domain.is_torus()),
          y_(domain.unit_bounds().height(), distance, domain.is_torus()),
          wanted_(x_.nodes * y_.nodes),
          there_(wanted_.size()) {
        const float per_reference = 1 / static_cast<float>(reference.size());
        for (const Point p : reference) add(around(p), per_reference, wanted_);
        around_.reserve(points.size());
        for (const Point p : points) {
            around_.push_back(around(p));
            add(around_.back(), 1, there_);
        }
        join(wanted_);
        join(there_);
    }

    /// Points around one that there should be, of one in all.
    float wanted(std::uint32_t point) const { return read(around_[point], wanted_); }

    /// Points around one that there are.
    float there(std::uint32_t point) const { return read(around_[point], there_); }

    void remove(std::uint32_t point) {
        const Around& at = around_[point];
        const bool repeats = at.column < 2 || at.column + 2 >= x_.period || at.row < 2 || at.row + 2 >= y_.period;
        if (!repeats) return add(at, -1, there_);
        const Weights x = spline(at.x), y = spline(at.y);
        for (std::size_t j = 0; j < 3; ++j) {
            for (std::size_t i = 0; i < 3; ++i) lower(at.column + i, at.row + j, x[i] * y[j]);
        }
    }

private:
    using Weights = std::array<float, 3>;

    /// Nodes along one side, in the middles of its cells and of one cell beyond either end. Those a period apart are
    /// the same one.
    struct Axis {
        Axis(double length, double distance, bool torus)
            : cells(std::max(1.0, std::floor(length / distance))),
              cells_per_length(cells / length),
              nodes(static_cast<std::size_t>(cells) + 2),
              period(torus ? nodes - 2 : nodes) {}

        /// Cell of a place, counted in cells. @param place  length, changed to the share of the cell that is before it
        std::size_t cell(double& place) const {
            place = std::clamp(place * cells_per_length, 0.0, cells);
            const double cell = std::min(std::floor(place), cells - 1);
            place -= cell;
            return static_cast<std::size_t>(cell);
        }

        double cells;
        double cells_per_length;
        std::size_t nodes, period;
    };

    /// Nine nodes around a place, by the lowest one, and the place within the cell of the middle one, in [0, 1].
    struct Around {
        std::uint32_t column, row;
        float x, y;
    };

    Around around(Point p) const {
        const std::size_t column = x_.cell(p.x), row = y_.cell(p.y);
        return {static_cast<std::uint32_t>(column), static_cast<std::uint32_t>(row), static_cast<float>(p.x),
                static_cast<float>(p.y)};
    }

    std::size_t node(const Around& at) const { return at.row * x_.nodes + at.column; }

    float read(const Around& at, const std::vector<float>& nodes) const {
        const Weights x = spline(at.x), y = spline(at.y);
        float sum = 0;
        for (std::size_t j = 0; j < 3; ++j) {
            const float* row = nodes.data() + node(at) + j * x_.nodes;
            sum += y[j] * (x[0] * row[0] + x[1] * row[1] + x[2] * row[2]);
        }
        return sum;
    }

    /// Weights of the cell's node and its two neighbours.
    static Weights spline(float t) { return {(1 - t) * (1 - t) / 2, 0.5F + t * (1 - t), t * t / 2}; }

    /// Adds a multiple of the weights to the nodes around.
    void add(const Around& at, float factor, std::vector<float>& nodes) const {
        const Weights x = spline(at.x), y = spline(at.y);
        for (std::size_t j = 0; j < 3; ++j) {
            for (std::size_t i = 0; i < 3; ++i) nodes[node(at) + j * x_.nodes + i] += factor * y[j] * x[i];
        }
    }

    /// Lowers a node and those that are the same one.
    void lower(std::size_t column, std::size_t row, float weight) {
        for (std::size_t y = row % y_.period; y < y_.nodes; y += y_.period) {
            for (std::size_t x = column % x_.period; x < x_.nodes; x += x_.period) there_[y * x_.nodes + x] -= weight;
        }
    }

    /// Sums nodes that are the same ones.
    void join(std::vector<float>& nodes) const {
        for (std::size_t y = 0; y < y_.nodes; ++y) {
            for (std::size_t x = 0; x < x_.nodes; ++x) {
                if (x < x_.period && y < y_.period) continue;
                nodes[y % y_.period * x_.nodes + x % x_.period] += nodes[y * x_.nodes + x];
            }
        }
        for (std::size_t y = 0; y < y_.nodes; ++y) {
            for (std::size_t x = 0; x < x_.nodes; ++x)
                nodes[y * x_.nodes + x] = nodes[y % y_.period * x_.nodes + x % x_.period];
        }
    }

    Axis x_, y_;
    std::vector<float> wanted_;   ///< [nodes] of one point in all
    std::vector<float> there_;    ///< [nodes]
    std::vector<Around> around_;  ///< of points
};

/// Eight numbers that the processor handles as one, or in parts, by the same operations.
constexpr std::uint32_t kLanes = 8;
using Floats = float __attribute__((vector_size(kLanes * sizeof(float))));
using Ints = std::int32_t __attribute__((vector_size(kLanes * sizeof(float))));
using Places = std::uint32_t __attribute__((vector_size(kLanes * sizeof(float))));
constexpr Ints kLane = {0, 1, 2, 3, 4, 5, 6, 7};
constexpr float kNone = -std::numeric_limits<float>::infinity();

/// Eight numbers that need not be aligned.
template <class Wide, class Number>
CCDT_INLINE inline void load(const Number& first, Wide& numbers) {
    std::memcpy(&numbers, &first, sizeof numbers);
}

/// Points that crowd each other, listed by cells: neighbours stand next to each other and are handled eight at a time.
class Crowd {
public:
    /// Two points that are near each other.
    struct Pair {
        float square;  ///< of the share that their distance has of the reach
        std::uint32_t i, j;
    };

    /// @param reaches  [n] within which points crowd each other
    Crowd(const Domain& domain, std::span<const Point> places, std::span<const double> reaches, double widest,
          Team& team, const std::stop_token& stop)
        : cells_(domain, places),
          numbers_(cells_.numbers()),
          places_(places),
          reaches_(reaches),
          widest_(widest),
          slots_(places.size()),
          x_(places.size() + kLanes),
          y_(places.size() + kLanes),
          nearness_(places.size() + kLanes),
          crowding_(places.size() + kLanes) {
        // Integers wrap around as a torus does: their difference is that to the nearest copy.
        const double range = domain.is_torus() ? 0x1p32 : 0x1p31, usual = reaches[0];
        const Point sides = domain.unit_bounds().max;
        for (std::uint32_t k = 0; k < numbers_.size(); ++k) {
            const std::uint32_t i = numbers_[k];
            slots_[i] = k;
            x_[k] = static_cast<std::uint32_t>(static_cast<std::int64_t>(places[i].x / sides.x * range));
            y_[k] = static_cast<std::uint32_t>(static_cast<std::int64_t>(places[i].y / sides.y * range));
            nearness_[k] = static_cast<float>(usual / reaches[i]);
        }
        x_unit_ = static_cast<float>(sides.x / range / usual);
        y_unit_ = static_cast<float>(sides.y / range / usual);
        std::vector<std::vector<Pair>> pairs((places.size() + kRange - 1) / kRange);
        for_ranges(team, places.size(), kRange, [&](std::size_t begin, std::size_t end) {
            std::vector<CellList::Run> runs;
            for (auto k = static_cast<std::uint32_t>(begin); k < end && !stop.stop_requested(); ++k) {
                find_near(k, 1, runs);
                const float nearest = is_wide_ ? add_wide(k, runs) : add_narrow(k, runs);
                if (nearest < kLeastSquare) find_pairs(k, pairs[begin / kRange]);
            }
        });
        for (const auto& each : pairs) pairs_.insert(pairs_.end(), each.begin(), each.end());
        std::ranges::sort(pairs_, {}, [](const Pair& pair) { return std::tuple(pair.square, pair.i, pair.j); });
    }

    /// Those that come too near in a step, the nearest first; where points coincide some of them.
    std::span<const Pair> pairs() const { return pairs_; }

    float operator()(std::uint32_t point) const { return crowding_[slots_[point]]; }

    void remove(std::uint32_t point) {
        const std::uint32_t k = slots_[point];
        find_near(k, 1, runs_);
        is_wide_ ? subtract_wide(k) : subtract_narrow(k);
        crowding_[k] = kNone;
    }

private:
    static constexpr std::size_t kRange = 4'096;  ///< points of a task
    static constexpr float kLeastSquare = static_cast<float>((kLeastDistance / kReach) * (kLeastDistance / kReach));

    void find_near(std::uint32_t k, double share, std::vector<CellList::Run>& runs) const {
        const std::uint32_t i = numbers_[k];
        cells_.find_near(places_[i], share * widest_ * reaches_[i], runs);
    }

    /// Squared shares that the distances to a point have of the reach; 1 of what is behind the end, and of itself.
    CCDT_INLINE void get_squares(std::uint32_t k, std::uint32_t begin, std::uint32_t end, Floats& squares) const {
        Places columns, rows;
        Floats other;
        load(x_[begin], columns);
        load(y_[begin], rows);
        load(nearness_[begin], other);
        const Floats x = __builtin_convertvector(Ints(columns - x_[k]), Floats) * x_unit_;
        const Floats y = __builtin_convertvector(Ints(rows - y_[k]), Floats) * y_unit_;
        const Floats own = Floats{} + nearness_[k];
        const Floats nearer = other > own ? other : own, capped = nearer * nearer * kMostSquare, both = other * own;
        const Floats square = (x * x + y * y) * (both > capped ? both : capped);
        const Ints left = kLane + static_cast<std::int32_t>(begin);
        const Ints counts = (left < static_cast<std::int32_t>(end)) & (left != static_cast<std::int32_t>(k));
        squares = counts ? square : Floats{} + 1;
    }

    CCDT_INLINE static void get_crowding(const Floats& squares, Floats& crowding) {
        const Floats left = squares < 1 ? 1 - squares : Floats{}, square = left * left;
        const Floats factor =
            kCrowding[0] + left * (kCrowding[1] + left * (kCrowding[2] + left * (kCrowding[3] + left * kCrowding[4])));
        crowding = square * square * left * factor;
    }

    /// Sums the crowding of a point. @returns the square of the nearest one
    CCDT_INLINE float add(std::uint32_t k, const std::vector<CellList::Run>& runs) {
        Floats sum{}, nearest = Floats{} + 1;
        for (const auto [begin, end] : runs) {
            for (std::uint32_t each = begin; each < end; each += kLanes) {
                Floats squares, crowding;
                get_squares(k, each, end, squares);
                get_crowding(squares, crowding);
                sum += crowding;
                nearest = squares < nearest ? squares : nearest;
            }
        }
        float all = 0, least = 1;
        for (std::uint32_t lane = 0; lane < kLanes; ++lane) {
            all += sum[lane];
            least = std::min(least, nearest[lane]);
        }
        crowding_[k] = all;
        return least;
    }
    CCDT_TWO_LANES float add_wide(std::uint32_t k, const std::vector<CellList::Run>& runs) { return add(k, runs); }
    float add_narrow(std::uint32_t k, const std::vector<CellList::Run>& runs) { return add(k, runs); }

    CCDT_INLINE void subtract(std::uint32_t k) {
        for (const auto [begin, end] : runs_) {
            for (std::uint32_t each = begin; each < end; each += kLanes) {
                Floats squares, crowding;
                get_squares(k, each, end, squares);
                get_crowding(squares, crowding);
                Floats crowded;
                load(crowding_[each], crowded);
                crowded -= crowding;
                std::memcpy(&crowding_[each], &crowded, sizeof crowded);
            }
        }
    }
    CCDT_TWO_LANES void subtract_wide(std::uint32_t k) { subtract(k); }
    void subtract_narrow(std::uint32_t k) { subtract(k); }

    void find_pairs(std::uint32_t k, std::vector<Pair>& pairs) const {
        std::vector<CellList::Run> runs;
        find_near(k, kLeastDistance / kReach, runs);
        for (const auto [begin, end] : runs) {
            for (std::uint32_t each = begin; each < end; each += kLanes) {
                Floats squares;
                get_squares(k, each, end, squares);
                for (std::uint32_t lane = 0; lane < kLanes; ++lane) {
                    if (squares[lane] < kLeastSquare && each + lane > k && pairs.size() < 3 * kRange)
                        pairs.push_back({squares[lane], numbers_[k], numbers_[each + lane]});
                }
            }
        }
    }

    const bool is_wide_ = has_two_lanes();
    CellList cells_;
    std::vector<std::uint32_t> numbers_;  ///< of points, as they are listed
    std::span<const Point> places_;
    std::span<const double> reaches_;
    double widest_;
    std::vector<std::uint32_t> slots_;  ///< of points in the list
    std::vector<Pair> pairs_;
    std::vector<CellList::Run> runs_;  ///< of the point that is removed
    float x_unit_, y_unit_;            ///< of coordinates, over the first point's reach

    // As listed, and eight behind the end.
    std::vector<std::uint32_t> x_, y_;
    std::vector<float> nearness_;  ///< the first point's reach over the own one
    std::vector<float> crowding_;
};

/// Takes points away, a step after the other, in which reaches stay the same.
class Elimination {
public:
    /// @param even  all spacings are the same
    Elimination(const Domain& domain, std::vector<Point> places, std::vector<double> spacings, bool even,
                Regions regions, Team& team)
        : domain_(domain),
          places_(std::move(places)),
          spacings_(std::move(spacings)),
          widest_(even ? 1 : kMostReach),
          regions_(std::move(regions)),
          left_(places_.size()),
          reference_(places_),
          team_(team) {
        std::iota(left_.begin(), left_.end(), 0U);
    }

    /// Takes a step. @returns the points that went, the first one first
    std::vector<std::uint32_t> step(const std::stop_token& stop) {
        target_ = static_cast<std::size_t>(static_cast<double>(left_.size()) * kStep);
        set_neighbours(stop);
        depth_ = regions_.depth(left_.size());
        begins_ = {0};
        for (const std::uint32_t count : regions_.left(depth_)) begins_.push_back(begins_.back() + count);
        std::vector<std::uint32_t> gone;
        gone.reserve(left_.size() - target_);
        while (gone.size() < left_.size() - target_) {
            if (gone.size() % kStopStride == 0 && stop.stop_requested()) break;
            const std::uint32_t i = next(left_.size() - gone.size() - 1);
            remove(i);
            gone.push_back(left_[i]);
        }
        keep_rest();
        return gone;
    }

    const std::vector<std::uint32_t>& left() const { return left_; }

private:
    void set_neighbours(const std::stop_token& stop) {
        const double share = std::max(static_cast<double>(target_), 1.0) / static_cast<double>(places_.size());
        const double reach = kReach * hexagonal_spacing(share);
        near_places_.clear();
        reaches_.clear();
        for (const std::uint32_t i : left_) {
            near_places_.push_back(places_[i]);
            reaches_.push_back(reach * spacings_[i]);
        }
        crowd_.emplace(domain_, near_places_, reaches_, widest_, team_, stop);
        next_pair_ = 0;
        is_there_.assign(left_.size(), 1);
        if (reference_.size() > kManyTimes * left_.size()) {
            sparse_ = near_places_;
            reference_ = sparse_;
        }
        surplus_.emplace(domain_, reference_, near_places_, node_distance());
        bounds_.resize(left_.size() + kLanes);
        wanted_.resize(left_.size() + kLanes);
        for_ranges(team_, left_.size(), kStopStride, [&](std::size_t begin, std::size_t end) {
            for (auto i = static_cast<std::uint32_t>(begin); i < end; ++i) {
                wanted_[i] = kSurplusWeight * surplus_->wanted(i);
                bounds_[i] = without_wanted(i);
            }
        });
    }

    /// Of nodes that are no more than about as many as the points, whatever the domain's shape.
    double node_distance() const {
        const Box box = domain_.unit_bounds();
        const double stay = std::max(static_cast<double>(target_), 1.0), left = static_cast<double>(left_.size());
        return std::max({kNodeDistance * hexagonal_spacing(stay / domain_.unit_area()),
                         std::sqrt(box.width() * box.height() / left), std::max(box.width(), box.height()) / left});
    }

    /// Point to go next: one of two that would be too near each other among so many that stay, if there are such.
    std::uint32_t next(std::size_t stay) {
        const double grown = static_cast<double>(target_) / static_cast<double>(std::max<std::size_t>(stay, 1));
        const double least = kLeastDistance / kReach * std::sqrt(grown);
        const auto left = static_cast<float>(stay + 1);
        const std::span<const Crowd::Pair> pairs = crowd_->pairs();
        for (; next_pair_ < pairs.size() && pairs[next_pair_].square < least * least; ++next_pair_) {
            const auto [square, i, j] = pairs[next_pair_];
            if (is_there_[i] != 0 && is_there_[j] != 0) return excess(i, left) > excess(j, left) ? i : j;
        }
        const std::size_t region = regions_.turn(depth_);
        return most_crowded(begins_[region], begins_[region + 1], left);
    }

    float without_wanted(std::uint32_t i) const { return (*crowd_)(i) + kSurplusWeight * surplus_->there(i); }
    float excess(std::uint32_t i, float left) const { return without_wanted(i) - left * wanted_[i]; }

    /// Finds the point of the largest excess. Both of its parts that are not known beforehand only fall in a step, so
    /// that what they were is a bound of what they are.
    std::uint32_t most_crowded(std::uint32_t begin, std::uint32_t end, float left) {
        Ints found;
        is_wide_ ? find_largest_wide(begin, end, left, found) : find_largest_narrow(begin, end, left, found);
        std::uint32_t most = begin;
        float largest = kNone;
        const auto look_at = [&](std::uint32_t i) {
            bounds_[i] = without_wanted(i);
            const float own = bounds_[i] - left * wanted_[i];
            if (own < largest || (own == largest && i > most)) return;
            largest = own;
            most = i;
        };
        for (std::uint32_t lane = 0; lane < kLanes; ++lane) look_at(static_cast<std::uint32_t>(found[lane]));
        for (std::uint32_t i = begin; i < end; ++i) {
            if (bounds_[i] - left * wanted_[i] > largest) look_at(i);
        }
        return most;
    }

    /// Finds a point of a large bound, of every eighth one the largest.
    CCDT_INLINE void find_largest(std::uint32_t begin, std::uint32_t end, float left, Ints& found) const {
        Floats most = Floats{} + kNone;
        found = Ints{} + static_cast<std::int32_t>(begin);
        for (std::uint32_t i = begin; i < end; i += kLanes) {
            const Ints each = kLane + static_cast<std::int32_t>(i);
            Floats bounds, wanted;
            load(bounds_[i], bounds);
            load(wanted_[i], wanted);
            const Floats bound = bounds - left * wanted;
            const Ints more = (bound > most) & (each < static_cast<std::int32_t>(end));
            most = more ? bound : most;
            found = more ? each : found;
        }
    }
    CCDT_TWO_LANES void find_largest_wide(std::uint32_t begin, std::uint32_t end, float left, Ints& found) const {
        find_largest(begin, end, left, found);
    }
    void find_largest_narrow(std::uint32_t begin, std::uint32_t end, float left, Ints& found) const {
        find_largest(begin, end, left, found);
    }

    void remove(std::uint32_t i) {
        is_there_[i] = 0;
        bounds_[i] = kNone;
        crowd_->remove(i);
        surplus_->remove(i);
        const auto region = std::ranges::upper_bound(begins_, i) - begins_.begin() - 1;
        regions_.take(depth_, static_cast<std::size_t>(region));
    }

    void keep_rest() {
        std::size_t kept = 0;
        for (std::size_t i = 0; i < left_.size(); ++i) {
            if (is_there_[i] != 0) left_[kept++] = left_[i];
        }
        left_.resize(kept);
    }

    const Domain& domain_;
    const bool is_wide_ = has_two_lanes();
    std::vector<Point> places_;     ///< [n] in the unit frame
    std::vector<double> spacings_;  ///< [n]
    double widest_;                 ///< reach of a point and another one, over its own
    Regions regions_;
    std::vector<std::uint32_t> left_;
    std::span<const Point> reference_;  ///< points of all's density
    std::vector<Point> sparse_;         ///< them, when they are no longer all
    Team& team_;

    // Of those left when the step began.
    std::size_t target_ = 0;             ///< points left at its end
    int depth_ = 0;                      ///< of regions
    std::vector<std::uint32_t> begins_;  ///< of regions
    std::vector<Point> near_places_;
    std::vector<double> reaches_;
    std::optional<Crowd> crowd_;
    std::vector<std::uint8_t> is_there_;
    std::optional<Surplus> surplus_;
    std::vector<float> wanted_;  ///< of the surplus' weighted part, for one point that is left
    std::vector<float> bounds_;  ///< of excess without what is wanted
    std::size_t next_pair_ = 0;
};

/// @param even  points are as dense everywhere
/// @returns     spacing around each
std::vector<double> spacings_of(const Domain& domain, std::span<const Point> places, bool even, Team& team,
                                const std::stop_token& stop) {
    const double usual = std::sqrt(domain.unit_area() / static_cast<double>(places.size()));
    std::vector<double> spacings(places.size(), usual);
    if (even) return spacings;
    const CellList near(domain, places);
    for_ranges(team, places.size(), kStopStride, [&](std::size_t begin, std::size_t end) {
        if (stop.stop_requested()) return;
        SpacingMeter meter(domain, places, near, usual);
        for (auto i = static_cast<std::uint32_t>(begin); i < end; ++i) spacings[i] = meter(i);
    });
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
                                        const std::stop_token& stop, Team& team) {
    std::vector<std::uint32_t> order;
    if (unsorted.empty()) return order;
    std::vector<std::uint32_t> numbers(unsorted.size());
    std::iota(numbers.begin(), numbers.end(), 0U);
    Regions regions(unsorted, numbers);
    std::vector<Point> places;
    places.reserve(unsorted.size());
    for (const std::uint32_t i : numbers) places.push_back(unsorted[i]);
    std::vector<double> spacings = spacings_of(domain, places, even, team, stop);

    Elimination elimination(domain, std::move(places), std::move(spacings), even, std::move(regions), team);
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
                                             const std::stop_token& stop, Team& team) {
    std::vector<Point> places;
    places.reserve(points.size());
    for (const Point p : points) places.push_back(domain.to_unit(p));
    return order_places(domain, places, even, stop, team);
}

std::vector<std::uint32_t> progressive_order_on_globe(std::span<const Point> points, const std::stop_token& stop,
                                                      Team& team) {
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
    return order_places(square, places, false, stop, team);
}

}  // namespace ccdt
