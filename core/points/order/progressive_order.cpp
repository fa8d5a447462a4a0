// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/points/order/progressive_order.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>
#include <tuple>
#include <type_traits>
#include <utility>

#include "core/base/lanes.h"
#include "core/ccdt/globe/chart.h"
#include "core/ccdt/polish/cell_list.h"
#include "core/geometry/axes.h"
#include "core/geometry/hexagonal_spacing.h"
#include "core/geometry/point3.h"
#include "core/geometry/spreading.h"

namespace ccdt {

namespace {

constexpr std::size_t kStopStride = 1'024;  ///< points between polls of the stop token

// Benchmarks ProgressivePattern and ProgressiveTone show the quality that these constants reach, and test
// ProgressiveOrder requires it. A shorter reach increases the distance of neighbours and leaves more power in low
// frequencies. A longer reach does the opposite and takes longer.
constexpr double kReach = 1.7;  ///< relative to the hexagonal distance
constexpr double kStep = 0.7;   ///< share of the points that remain at the end of a step; reaches grow between steps

/// Least distance of remaining points, relative to the hexagonal distance. At most a third of the points of a hexagonal
/// grid can remain without any two being neighbours. The hexagonal distance is then sqrt(3) times as large, so
/// neighbours in the original grid are 1 / sqrt(3) = 0.577 apart. A larger value would separate them while more than a
/// third of the points remain, and leave more power in low frequencies.
constexpr double kMinDistance = 0.58;

/// Ratio of remaining points to removals that are planned ahead. Points of the best quality are nearly a hexagonal
/// grid, in which many pairs become too near to each other at about the same time. With a ratio of 16, the least
/// distance of 16,384 such points in a polygon is 0.579. With a ratio of 4, there is 1 dB more power in long waves on
/// surfaces.
constexpr std::size_t kPlanRatio = 8;

/// Weight of the surplus around a point, relative to the crowding of the point. A larger weight leaves less power in
/// long waves, and more power in waves of two or three spacings.
constexpr float kSurplusWeight = 0.5F;

/// Distance of the grid nodes on which the surplus is smoothed (see Surplus), relative to the hexagonal distance.
constexpr double kNodeDistance = 3;

/// Factor of the spline weights in space, relative to the plane. Along the normal of a surface, each point adds its
/// weights to the nodes of a line, and reads them with the same weights. The sum of the squared weights is 11/20 on
/// average. With this factor, points on a flat surface have the same surplus as in the plane.
constexpr float kSpaceFactor = 1.3484F;  // 1 / sqrt(11/20)

/// Ratio of reference points (see Surplus) to remaining points above which the remaining points become the reference.
constexpr std::size_t kMaxReferenceRatio = 8;

/// Least number of remaining points in a region. Fewer points mean less choice and more noise. More points take
/// longer.
constexpr std::size_t kMinRegionPoints = 256;

/// Number of neighbours whose distance measures the local density. It is large enough for a stable measure, and small
/// enough for the neighbours to be near.
constexpr std::size_t kNeighbours = 12;

template <class P>
constexpr bool kInSpace = kAxes<P> == 3;

/// The box in which points lie: from the origin to `sides`, each of which is > 0. It has three dimensions for points in
/// space and on a surface.
template <class P>
struct PointBox {
    P sides;
    double size;  ///< area of the domain or surface; volume of a domain in space
    bool is_torus = false;
    bool is_solid = false;           ///< whether the domain has three dimensions
    const Domain* domain = nullptr;  ///< nullptr in space

    BasicCellList<P> cells(std::span<const P> positions) const {
        if constexpr (kInSpace<P>)
            return is_torus ? BasicCellList<P>(sides, positions) : BasicCellList<P>(positions);
        else
            return BasicCellList<P>(*domain, positions);
    }

    /// Returns the side of a square of a given area or, in a solid domain, of a cube of a given volume.
    double side_of(double part) const { return is_solid ? std::cbrt(part) : std::sqrt(part); }

    /// Returns the area of a square with a given side or, in a solid domain, the volume of a cube.
    double part_of(double side) const { return is_solid ? side * side * side : side * side; }

    /// Returns the spacing of a number of points at uniform density.
    double usual_spacing(std::size_t points) const { return side_of(size / static_cast<double>(points)); }
};

/// Points of a domain, or points on a surface with the surface's normals.
template <class P>
struct Points {
    std::vector<P> positions;
    std::vector<P> normals;  ///< [positions]; empty if the points are not on a surface

    std::size_t size() const { return positions.size(); }

    /// Whether two points are on opposite sides of a thin plate, so that they are not neighbours.
    bool are_opposed(std::uint32_t i, std::uint32_t j) const {
        return !normals.empty() && dot(normals[i], normals[j]) < 0;
    }

    /// Returns the points with the given numbers, in the given order.
    Points selected(std::span<const std::uint32_t> numbers) const {
        Points result;
        result.positions.reserve(numbers.size());
        for (const std::uint32_t i : numbers) result.positions.push_back(positions[i]);
        if (normals.empty()) return result;
        result.normals.reserve(numbers.size());
        for (const std::uint32_t i : numbers) result.normals.push_back(normals[i]);
        return result;
    }
};

/// Coefficients of a polynomial p that approximates the crowding by a neighbour. Let s be the neighbour's distance
/// divided by the reach. Then (1 - s)^5 is about (1 - s^2)^5 p(1 - s^2), with an error below 7 % for s from 1/3 to 0.9.
constexpr std::array<float, 5> kCrowding = {0.12919328F, -0.9645656F, 3.58161193F, -5.21164568F, 2.87339624F};

/// Limit on the reach of a pair of points, relative to the shorter of the two points' own reaches. Up to this limit,
/// the reach of a pair is the geometric mean of the two points' reaches. So where two densities meet, neither the
/// denser nor the sparser side loses more than its share.
constexpr double kMaxReach = 1.3;
constexpr float kMaxSquare = static_cast<float>(1 / (kMaxReach * kMaxReach));

/// Measures the local spacing of points, the side of the square or cube that holds one point, by the distance of their
/// nearest neighbours.
template <class P>
class SpacingMeter {
public:
    /// @param usual  spacing of the same number of points at uniform density
    SpacingMeter(const PointBox<P>& frame, const Points<P>& points, const BasicCellList<P>& near, double usual)
        : frame_(frame), points_(points), near_(near), usual_(usual) {
        for (std::size_t axis = 0; axis < kAxes<P>; ++axis) widest_ += 2 * along(frame.sides, axis);
    }

    double operator()(std::uint32_t point) {
        const std::size_t wanted = std::min(kNeighbours, points_.size() - 1);
        double reach = 2.2 * usual_;  // slightly beyond the usual distance of this number of neighbours
        while (!find(point, reach, wanted) && reach < widest_) reach *= 2;
        if (squares_.size() < wanted || wanted == 0) return usual_;
        const auto last = squares_.begin() + static_cast<std::ptrdiff_t>(wanted) - 1;
        std::ranges::nth_element(squares_, last);
        // Coincident points have spacing 0, but the spacing must be usable as a divisor.
        constexpr double kMinShare = 1e-9;
        const double ball = std::numbers::pi * *last * (frame_.is_solid ? std::sqrt(*last) * 4 / 3 : 1);
        return std::max(frame_.side_of(ball / static_cast<double>(wanted)), kMinShare * usual_);
    }

private:
    /// Whether there are enough neighbours within reach.
    bool find(std::uint32_t point, double reach, std::size_t wanted) {
        squares_.clear();
        near_.for_near(points_.positions[point], reach, [&](P position, std::uint32_t number) {
            const P apart = position - points_.positions[point];
            const double square = dot(apart, apart);
            if (number == point || square >= reach * reach || points_.are_opposed(point, number)) return;
            squares_.push_back(square);
        });
        return squares_.size() >= wanted;
    }

    const PointBox<P>& frame_;
    const Points<P>& points_;
    const BasicCellList<P>& near_;
    double usual_;
    double widest_ = 0;  ///< reach at which all points are found
    std::vector<double> squares_;
};

/// Returns the axis along which some points extend farthest.
template <class P>
std::size_t longest_axis(std::span<const P> positions, std::span<const std::uint32_t> numbers) {
    P min = positions[numbers[0]], max = min;
    for (const std::uint32_t i : numbers) {
        for (std::size_t axis = 0; axis < kAxes<P>; ++axis) {
            along(min, axis) = std::min(along(min, axis), along(positions[i], axis));
            along(max, axis) = std::max(along(max, axis), along(positions[i], axis));
        }
    }
    const P size = max - min;
    std::size_t longest = 0;
    for (std::size_t axis = 1; axis < kAxes<P>; ++axis) {
        if (along(size, axis) >= along(size, longest)) longest = axis;
    }
    return longest;
}

/// Regions with nearly equal numbers of points, made by recursive halving. Regions lose points in turn.
class Regions {
public:
    /// Sorts points by region.
    /// @param order  permutation of the points; reordered such that the points of each region are successive
    template <class P>
    Regions(std::span<const P> positions, std::vector<std::uint32_t>& order) {
        while ((order.size() >> depth_) >= 2 * kMinRegionPoints) ++depth_;
        sizes_.resize(std::size_t{2} << depth_);
        divide(positions, order, 1, 0);
        remaining_ = sizes_;
    }

    /// Returns the depth at which regions have enough points to choose from, if `remaining` points remain in the
    /// domain.
    int depth(std::size_t remaining) const {
        int depth = 0;
        while (depth < depth_ && (remaining >> (depth + 1)) >= kMinRegionPoints) ++depth;
        return depth;
    }

    /// Returns the number of remaining points in each region of a depth.
    std::span<const std::uint32_t> remaining(int depth) const {
        const std::size_t count = std::size_t{1} << depth;
        return std::span(remaining_).subspan(count, count);
    }

    /// Returns the region of a depth that loses the next point: at each level, the half with the larger share of
    /// remaining points.
    std::size_t next_region(int depth) const {
        std::size_t region = 1;
        for (int i = 0; i < depth; ++i) {
            const std::size_t first = 2 * region, second = first + 1;
            const std::uint64_t a = std::uint64_t{remaining_[first]} * sizes_[second];
            const std::uint64_t b = std::uint64_t{remaining_[second]} * sizes_[first];
            region = a > b || (a == b && is_first(region)) ? first : second;
        }
        return region - (std::size_t{1} << depth);
    }

    /// Counts the removal of a point from a region of a depth, whether or not the region was the next in turn.
    void count_removal(int depth, std::size_t region) {
        for (region += std::size_t{1} << depth; region > 0; region /= 2) --remaining_[region];
    }

private:
    /// Chooses pseudo-randomly between two halves with equal shares, so that neither loses points systematically.
    bool is_first(std::size_t region) const {
        std::uint64_t bits = (region << 32 | remaining_[region]) * 0x9e3779b97f4a7c15;
        bits = (bits ^ bits >> 32) * 0xd6e8feb86659fd93;
        return (bits >> 63) != 0;
    }

    template <class P>
    void divide(std::span<const P> positions, std::span<std::uint32_t> order, std::size_t region, int depth) {
        sizes_[region] = static_cast<std::uint32_t>(order.size());
        if (depth == depth_) return;
        const std::size_t axis = longest_axis<P>(positions, order);
        const auto position = [&](std::uint32_t i) { return along(positions[i], axis); };
        const std::size_t half = order.size() / 2;
        std::ranges::nth_element(
            order, order.begin() + static_cast<std::ptrdiff_t>(half),
            [&](std::uint32_t i, std::uint32_t j) { return std::pair(position(i), i) < std::pair(position(j), j); });
        divide(positions, order.first(half), 2 * region, depth + 1);
        divide(positions, order.subspan(half), 2 * region + 1, depth + 1);
    }

    int depth_ = 0;
    std::vector<std::uint32_t> sizes_;  ///< [2 << depth_] initial points; the halves of region i are 2 i and 2 i + 1
    std::vector<std::uint32_t> remaining_;  ///< [2 << depth_] remaining points
};

/// Measures the surplus of points around a point: the actual number minus the wanted number, both smoothed by quadratic
/// B-splines on the nodes of a square grid. The surplus suppresses long waves, which the distances of neighbours do not
/// reveal. In space the grid is cubic, and the two sides of a thin plate have a common surplus.
template <class P>
class Surplus {
public:
    /// @param reference  points with the wanted density, up to a common factor
    /// @param points     actual points, numbered from 0
    /// @param distance   distance of nodes
    Surplus(const PointBox<P>& frame, std::span<const P> reference, std::span<const P> points, double distance)
        : is_torus_(frame.is_torus),
          factor_(kInSpace<P> && !frame.is_solid ? kSpaceFactor : 1),
          x_(frame.sides.x, distance, is_torus_),
          y_(frame.sides.y, distance, is_torus_) {
        if constexpr (kInSpace<P>) z_ = Axis(frame.sides.z, distance, is_torus_);
        wanted_.resize(z_.nodes * y_.nodes * x_.nodes);
        actual_.resize(wanted_.size());
        const float per_reference = 1 / static_cast<float>(reference.size());
        for (const P p : reference) add(around(p), per_reference, wanted_);
        around_.reserve(points.size());
        for (const P p : points) {
            around_.push_back(around(p));
            add(around_.back(), 1, actual_);
        }
        if (is_torus_) {
            join(wanted_);
            join(actual_);
        }
    }

    /// Returns the smoothed number of points that are wanted around a point, divided by the number of all points.
    float wanted(std::uint32_t point) const { return read(around_[point], wanted_); }

    /// Returns the smoothed number of points that are around a point.
    float actual(std::uint32_t point) const { return read(around_[point], actual_); }

    void remove(std::uint32_t point) {
        const Around& at = around_[point];
        if (!is_torus_ || !(x_.repeats(at.column) || y_.repeats(at.row) || z_.repeats(layer_of(at))))
            return add(at, -1, actual_);
        for_layers(at, [&](std::size_t layer, float share) {
            for_taps(b_spline<2>(at.x), b_spline<2>(at.y), share, [&](std::size_t j, std::size_t i, float each) {
                lower({at.column + i, at.row + j, layer_of(at) + layer}, each);
            });
        });
    }

private:
    /// Nodes along one side, at the centres of the cells and of one further cell beyond each end. On a torus, nodes a
    /// period apart are identical.
    struct Axis {
        Axis() = default;
        Axis(double length, double distance, bool torus)
            : cells(std::max(1.0, std::floor(length / distance))),
              cells_per_length(cells / length),
              nodes(static_cast<std::size_t>(cells) + 2),
              period(torus ? nodes - 2 : nodes) {}

        /// Returns the cell of a position.
        /// @param position  position as a length on entry; on return the offset in the cell, in units of cells
        std::size_t cell(double& position) const {
            position = std::clamp(position * cells_per_length, 0.0, cells);
            const double cell = std::min(std::floor(position), cells - 1);
            position -= cell;
            return static_cast<std::size_t>(cell);
        }

        /// Whether some of the three nodes around a position in a cell of a torus are identical to other nodes.
        bool repeats(std::size_t cell) const { return nodes > 1 && (cell < 2 || cell + 2 >= period); }

        double cells = 1;
        double cells_per_length = 0;
        std::size_t nodes = 1, period = 1;
    };

    /// Position along the third axis of the grid, like `column` and `x` of Around.
    struct Depth {
        std::uint32_t layer = 0;
        float z = 0;
    };
    struct Nothing {};

    /// The nodes around a position: nine in the plane, 27 in space. `column` and `row` are those of the node at the
    /// lower left. `x` and `y` are the offset of the position in the cell of the middle node, in [0, 1].
    struct Around {
        std::uint32_t column, row;
        float x, y;
        [[no_unique_address]] std::conditional_t<kInSpace<P>, Depth, Nothing> depth;
    };

    Around around(P p) const {
        Around at{};
        at.column = static_cast<std::uint32_t>(x_.cell(p.x));
        at.row = static_cast<std::uint32_t>(y_.cell(p.y));
        at.x = static_cast<float>(p.x);
        at.y = static_cast<float>(p.y);
        if constexpr (kInSpace<P>) {
            at.depth.layer = static_cast<std::uint32_t>(z_.cell(p.z));
            at.depth.z = static_cast<float>(p.z);
        }
        return at;
    }

    static std::size_t layer_of(const Around& at) {
        if constexpr (kInSpace<P>) return at.depth.layer;
        return 0;
    }

    /// Calls function(layer, share) for each layer of nodes around a position. `layer` counts from the first of these.
    template <class Function>
    CCDT_INLINE void for_layers(const Around& at, Function&& function) const {
        if constexpr (kInSpace<P>) {
            const std::array<float, 3> shares = b_spline<2>(at.depth.z);
            for (std::size_t k = 0; k < shares.size(); ++k) function(k, factor_ * shares[k]);
        } else {
            function(0, 1.0F);
        }
    }

    /// Returns the index of the first of the nine nodes around a position in a layer.
    std::size_t first_node(const Around& at, std::size_t layer) const {
        return ((layer_of(at) + layer) * y_.nodes + at.row) * x_.nodes + at.column;
    }

    float read(const Around& at, const std::vector<float>& nodes) const {
        const std::array<float, 3> x = b_spline<2>(at.x), y = b_spline<2>(at.y);
        float sum = 0;
        for_layers(at, [&](std::size_t layer, float share) CCDT_INLINE {
            const float* const first = nodes.data() + first_node(at, layer);
            sum += share * sum_taps(x, y, [&](std::size_t row) { return first + row * x_.nodes; });
        });
        return sum;
    }

    /// Adds the spline weights of a position, multiplied by `factor`, to the nodes around it.
    void add(const Around& at, float factor, std::vector<float>& nodes) const {
        const std::array<float, 3> x = b_spline<2>(at.x), y = b_spline<2>(at.y);
        for_layers(at, [&](std::size_t layer, float share) CCDT_INLINE {
            float* const first = nodes.data() + first_node(at, layer);
            for_taps(x, y, factor * share,
                     [&](std::size_t j, std::size_t i, float each) { first[j * x_.nodes + i] += each; });
        });
    }

    /// Column, row and layer of a node.
    using Node = std::array<std::size_t, 3>;

    std::size_t index(Node at) const { return (at[2] * y_.nodes + at[1]) * x_.nodes + at[0]; }

    /// Returns the first of the nodes that are identical to a node.
    Node first_of(Node at) const { return {at[0] % x_.period, at[1] % y_.period, at[2] % z_.period}; }

    /// Subtracts from a node and from all nodes identical to it.
    void lower(Node node, float weight) {
        const auto [column, row, layer] = first_of(node);
        for (std::size_t z = layer; z < z_.nodes; z += z_.period) {
            for (std::size_t y = row; y < y_.nodes; y += y_.period) {
                for (std::size_t x = column; x < x_.nodes; x += x_.period) actual_[index({x, y, z})] -= weight;
            }
        }
    }

    template <class Visit>
    void for_nodes(Visit&& visit) const {
        for (std::size_t z = 0; z < z_.nodes; ++z) {
            for (std::size_t y = 0; y < y_.nodes; ++y) {
                for (std::size_t x = 0; x < x_.nodes; ++x) visit(index({x, y, z}), index(first_of({x, y, z})));
            }
        }
    }

    /// Sums identical nodes and stores the sum in each.
    void join(std::vector<float>& nodes) const {
        for_nodes([&](std::size_t node, std::size_t first) {
            if (node != first) nodes[first] += nodes[node];
        });
        for_nodes([&](std::size_t node, std::size_t first) { nodes[node] = nodes[first]; });
    }

    bool is_torus_;
    float factor_;
    Axis x_, y_, z_;
    std::vector<float> wanted_;   ///< [nodes] smoothed number of wanted points, divided by the number of all points
    std::vector<float> actual_;   ///< [nodes] smoothed number of actual points
    std::vector<Around> around_;  ///< nodes around each point
};

using Floats = EightLanes::Floats;
using Ints = EightLanes::Ints;
constexpr std::uint32_t kLanes = EightLanes::kCount;
constexpr float kNone = -std::numeric_limits<float>::infinity();

/// Describes the pairs of points that become too near to each other while points are removed. A relative distance is
/// a distance divided by `reach` or, without it, by the reach of the pair.
struct NearPairs {
    std::optional<double> reach;  ///< at most kMaxReach times the reach of a point
    double square;                ///< limit on the squares of relative distances; pairs farther apart are not listed
    double points;                ///< number of remaining points below which a relative distance of 1 is too small
};

/// Crowding of points, computed for eight points at a time. Points are listed by cell, so neighbours are close in
/// memory.
template <class P>
class Crowding {
public:
    /// Two points that are near each other.
    struct Pair {
        float limit;  ///< number of remaining points below which the two points are too near to each other
        std::uint32_t i, j;
    };

    /// @param reaches  [n] distance within which other points crowd each point
    /// @param widest   limit on the reach of a pair of points, relative to the reach of either point
    /// @param listed   describes the pairs to list
    Crowding(const PointBox<P>& frame, const Points<P>& points, std::span<const double> reaches, double widest,
             const NearPairs& listed, Executor& executor, const std::stop_token& stop)
        : is_solid_(frame.is_solid),
          listed_(listed),
          cells_(frame.cells(points.positions)),
          numbers_(cells_.numbers()),
          positions_(points.positions),
          reaches_(reaches),
          widest_(widest),
          slots_(points.size()),
          nearness_(points.size() + kLanes),
          crowding_(points.size() + kLanes) {
        // Integer coordinates wrap around like a torus, so their difference is the way to the nearest copy.
        const double range = frame.is_torus ? 0x1p32 : 0x1p31, usual = reaches[0];
        for (auto& each : coordinates_) each.resize(points.size() + kLanes);
        has_normals_ = !points.normals.empty();
        for (auto& each : normals_) each.resize(has_normals_ ? points.size() + kLanes : 0);
        for (std::uint32_t k = 0; k < numbers_.size(); ++k) {
            const std::uint32_t i = numbers_[k];
            slots_[i] = k;
            for (std::size_t axis = 0; axis < kAxes<P>; ++axis) {
                const double of_range = along(positions_[i], axis) / along(frame.sides, axis) * range;
                coordinates_[axis][k] = static_cast<std::uint32_t>(static_cast<std::int64_t>(of_range));
            }
            for (std::size_t axis = 0; has_normals_ && axis < normals_.size(); ++axis)
                normals_[axis][k] = static_cast<float>(along(points.normals[i], axis));
            nearness_[k] = static_cast<float>(usual / reaches[i]);
        }
        for (std::size_t axis = 0; axis < kAxes<P>; ++axis)
            units_[axis] = static_cast<float>(along(frame.sides, axis) / range / usual);
        double nearest_listed = listed_.square;  // relative to the reaches of points
        if (listed_.reach) {
            const double ratio = *listed_.reach / *std::ranges::min_element(reaches);
            nearest_listed *= std::max(1.0, ratio * ratio);
            scale_ = static_cast<float>((usual / *listed_.reach) * (usual / *listed_.reach));
        }
        std::vector<std::vector<Pair>> pairs((points.size() + kRange - 1) / kRange);
        for_ranges(executor, points.size(), kRange, [&](std::size_t begin, std::size_t end) {
            Runs runs;
            for (auto k = static_cast<std::uint32_t>(begin); k < end && !stop.stop_requested(); ++k) {
                find_near(k, 1, runs);
                const float nearest = with_lanes([&](auto) CCDT_INLINE { return add(k, runs); });
                if (nearest < nearest_listed) find_pairs(k, pairs[begin / kRange]);
            }
        });
        for (const auto& each : pairs) pairs_.insert(pairs_.end(), each.begin(), each.end());
        std::ranges::sort(pairs_, {}, [](const Pair& pair) { return std::tuple(-pair.limit, pair.i, pair.j); });
    }

    /// The pairs to list, in ascending order of their relative distance. Of many coincident points, only some pairs are
    /// listed.
    std::span<const Pair> pairs() const { return pairs_; }

    float operator()(std::uint32_t point) const { return crowding_[slots_[point]]; }

    void remove(std::uint32_t point) {
        const std::uint32_t k = slots_[point];
        find_near(k, 1, runs_);
        with_lanes([&](auto) CCDT_INLINE { subtract(k); });
        crowding_[k] = kNone;
    }

private:
    using Runs = std::vector<typename BasicCellList<P>::Run>;

    static constexpr std::size_t kRange = 4'096;  ///< points per task

    void find_near(std::uint32_t k, double share, Runs& runs) const {
        const std::uint32_t i = numbers_[k];
        cells_.find_near(positions_[i], share * widest_ * reaches_[i], runs);
    }

    /// Computes, for the eight points from list position `begin` on, the squared ratio of their distance from point k
    /// to the reach of the pair. Points from `end` on, k itself, and points with an opposed normal get 1.
    /// @param scale  if not 0, factor of squares relative to the first point's reach, instead of those of the pairs
    CCDT_INLINE void get_squares(std::uint32_t k, std::uint32_t begin, std::uint32_t end, Floats& squares,
                                 float scale = 0) const {
        Floats distance{};
        for (std::size_t axis = 0; axis < kAxes<P>; ++axis) {
            EightLanes::Counts each;
            EightLanes::load(coordinates_[axis][begin], each);
            const Floats apart = __builtin_convertvector(Ints(each - coordinates_[axis][k]), Floats) * units_[axis];
            distance += apart * apart;
        }
        Floats other;
        EightLanes::load(nearness_[begin], other);
        const Floats own = Floats{} + nearness_[k];
        const Floats nearer = other > own ? other : own, capped = nearer * nearer * kMaxSquare, both = other * own;
        const Floats square = distance * (scale > 0 ? Floats{} + scale : both > capped ? both : capped);
        const Ints remaining = EightLanes::from(begin);
        Ints counts = (remaining < static_cast<std::int32_t>(end)) & (remaining != static_cast<std::int32_t>(k));
        if (kInSpace<P> && has_normals_) {
            Floats facing{};
            for (std::size_t axis = 0; axis < 3; ++axis) {
                Floats each;
                EightLanes::load(normals_[axis][begin], each);
                facing += each * normals_[axis][k];
            }
            counts &= facing >= 0;
        }
        squares = counts ? square : Floats{} + 1;
    }

    CCDT_INLINE static void get_crowding(const Floats& squares, Floats& crowding) {
        const Floats remaining = squares < 1 ? 1 - squares : Floats{}, square = remaining * remaining;
        const Floats factor =
            kCrowding[0] +
            remaining *
                (kCrowding[1] + remaining * (kCrowding[2] + remaining * (kCrowding[3] + remaining * kCrowding[4])));
        crowding = square * square * remaining * factor;
    }

    /// Computes the crowding of point k by the points in `runs`.
    /// @returns     the squared ratio of distance to reach for the nearest point
    CCDT_INLINE float add(std::uint32_t k, const Runs& runs) {
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

    CCDT_INLINE void subtract(std::uint32_t k) {
        for (const auto [begin, end] : runs_) {
            for (std::uint32_t each = begin; each < end; each += kLanes) {
                Floats squares, crowding;
                get_squares(k, each, end, squares);
                get_crowding(squares, crowding);
                Floats crowded;
                EightLanes::load(crowding_[each], crowded);
                crowded -= crowding;
                EightLanes::store(crowded, crowding_[each]);
            }
        }
    }

    void find_pairs(std::uint32_t k, std::vector<Pair>& pairs) const {
        const std::uint32_t i = numbers_[k];
        Runs runs;
        cells_.find_near(positions_[i], std::sqrt(listed_.square) * listed_.reach.value_or(widest_ * reaches_[i]),
                         runs);
        for (const auto [begin, end] : runs) {
            for (std::uint32_t each = begin; each < end; each += kLanes) {
                Floats squares;
                get_squares(k, each, end, squares, scale_);
                for (std::uint32_t lane = 0; lane < kLanes; ++lane) {
                    const float square = squares[lane];
                    if (square >= listed_.square || each + lane <= k || pairs.size() >= 3 * kRange) continue;
                    const float part = is_solid_ ? square * std::sqrt(square) : square;
                    pairs.push_back({static_cast<float>(listed_.points) / part, i, numbers_[each + lane]});
                }
            }
        }
    }

    bool is_solid_;
    NearPairs listed_;
    float scale_ = 0;  ///< squared ratio of the first point's reach to listed_.reach; 0 if there is none
    BasicCellList<P> cells_;
    std::vector<std::uint32_t> numbers_;  ///< numbers of the points in list order
    std::span<const P> positions_;
    std::span<const double> reaches_;
    double widest_;
    std::vector<std::uint32_t> slots_;  ///< list position of each point
    std::vector<Pair> pairs_;
    Runs runs_;  ///< neighbours of the point being removed
    bool has_normals_;
    std::array<float, kAxes<P>> units_{};  ///< length of a unit of each coordinate, relative to the first point's reach

    // The following vectors are in list order, with eight additional entries at the end.
    std::array<std::vector<std::uint32_t>, kAxes<P>> coordinates_;
    std::array<std::vector<float>, kInSpace<P> ? 3 : 0> normals_;
    std::vector<float> nearness_;  ///< ratio of the first point's reach to each point's own reach
    std::vector<float> crowding_;
};

/// Removes points in steps. During a step, all reaches (distances within which points crowd each other) stay the same.
template <class P>
class Elimination {
public:
    /// @param even     whether all spacings are equal
    /// @param uniform  whether the density is uniform
    Elimination(const PointBox<P>& frame, Points<P> points, std::vector<double> spacings, bool even, bool uniform,
                Regions regions, Executor& executor)
        : frame_(frame),
          points_(std::move(points)),
          spacings_(std::move(spacings)),
          widest_(even ? 1 : kMaxReach),
          uniform_(uniform),
          regions_(std::move(regions)),
          remaining_(points_.size()),
          reference_(points_.positions),
          executor_(executor) {
        std::iota(remaining_.begin(), remaining_.end(), 0U);
    }

    /// Runs a step.
    /// @returns  the removed points, in order of removal
    std::vector<std::uint32_t> step(const std::stop_token& stop) {
        target_ = static_cast<std::size_t>(static_cast<double>(remaining_.size()) * kStep);
        set_neighbours(stop);
        depth_ = regions_.depth(remaining_.size());
        begins_ = {0};
        for (const std::uint32_t count : regions_.remaining(depth_)) begins_.push_back(begins_.back() + count);
        std::vector<std::uint32_t> removed;
        removed.reserve(remaining_.size() - target_);
        while (removed.size() < remaining_.size() - target_) {
            if (removed.size() % kStopStride == 0 && stop.stop_requested()) break;
            const std::uint32_t i = next(remaining_.size() - removed.size() - 1);
            remove(i);
            removed.push_back(remaining_[i]);
        }
        keep_rest();
        return removed;
    }

    const std::vector<std::uint32_t>& remaining() const { return remaining_; }

private:
    void set_neighbours(const std::stop_token& stop) {
        const double share = std::max(static_cast<double>(target_), 1.0) / static_cast<double>(points_.size());
        const double reach = kReach * densest_spacing(share, frame_.is_solid);
        near_ = points_.selected(remaining_);
        reaches_.clear();
        for (const std::uint32_t i : remaining_) reaches_.push_back(reach * spacings_[i]);
        NearPairs listed{{}, 1, static_cast<double>(target_) * frame_.part_of(kMinDistance / kReach)};
        if (uniform_) listed.reach = reach * frame_.usual_spacing(points_.size());
        if (const std::size_t last = last_planned(target_); last > 0)
            listed.square = std::min(1.0, std::pow(frame_.side_of(listed.points / static_cast<double>(last)), 2));
        crowd_.emplace(frame_, near_, reaches_, widest_, listed, executor_, stop);
        next_pair_ = 0;
        next_plan_ = remaining_.size();
        is_present_.assign(remaining_.size(), 1);
        if (reference_.size() > kMaxReferenceRatio * remaining_.size()) {
            sparse_ = near_.positions;
            reference_ = sparse_;
        }
        surplus_.emplace(frame_, reference_, near_.positions, node_distance());
        bounds_.resize(remaining_.size() + kLanes);
        wanted_.resize(remaining_.size() + kLanes);
        for_ranges(executor_, remaining_.size(), kStopStride, [&](std::size_t begin, std::size_t end) {
            for (auto i = static_cast<std::uint32_t>(begin); i < end; ++i) {
                wanted_[i] = kSurplusWeight * surplus_->wanted(i);
                bounds_[i] = without_wanted(i);
            }
        });
    }

    /// Returns the distance of the surplus' grid nodes: so large that the nodes hardly outnumber the points.
    double node_distance() const {
        const double stay = std::max(static_cast<double>(target_), 1.0),
                     remaining = static_cast<double>(remaining_.size());
        double longest = 0;
        for (std::size_t axis = 0; axis < kAxes<P>; ++axis) longest = std::max(longest, along(frame_.sides, axis));
        return std::max({kNodeDistance * densest_spacing(stay / frame_.size, frame_.is_solid),
                         cell_side(frame_.sides, remaining), longest / remaining});
    }

    /// Returns the number of points that remain after the removals that are planned while `stay` points remain. If
    /// spacings are measured, they are not exact enough for a plan.
    std::size_t last_planned(std::size_t stay) const {
        return uniform_ ? stay - std::min(stay, 1 + stay / kPlanRatio) : stay;
    }

    bool is_there(const typename Crowding<P>::Pair& pair) const {
        return is_present_[pair.i] != 0 && is_present_[pair.j] != 0;
    }

    /// Returns the point to remove next, after which `stay` points remain. If the nearest pair must be separated,
    /// returns one of its points. Otherwise returns the point with the largest excess in the region that is next in
    /// turn.
    std::uint32_t next(std::size_t stay) {
        const auto remaining = static_cast<float>(stay + 1);
        if (must_separate(stay)) {
            const auto [limit, i, j] = crowd_->pairs()[next_pair_];
            return excess(i, remaining) > excess(j, remaining) ? i : j;
        }
        const std::size_t region = regions_.next_region(depth_);
        return most_crowded(begins_[region], begins_[region + 1], remaining);
    }

    /// Whether the next removal, after which `stay` points remain, must separate the nearest pair. It must if the pair
    /// would be too near, or if too many pairs become too near soon. Each removal is expected to separate one pair.
    bool must_separate(std::size_t stay) {
        const auto pairs = crowd_->pairs();
        while (next_pair_ < pairs.size() && !is_there(pairs[next_pair_])) ++next_pair_;
        if (next_pair_ == pairs.size()) return false;
        if (pairs[next_pair_].limit > static_cast<float>(stay)) return true;
        if (stay < next_plan_) plan(stay);
        return is_urgent_;
    }

    /// Determines `is_urgent_`, and for how many removals it is valid. If `count` pairs become too near before `limit`
    /// points remain, their separation must begin when limit + count points remain.
    void plan(std::size_t stay) {
        // A plan for few of very many removals would take too long.
        const std::size_t longest = 1 + stay / 64, shortest = 1 + stay / 4'096, urgent = 1 + stay / 1'024;
        const auto last = static_cast<float>(last_planned(stay)), latest = static_cast<float>(stay + 2 - shortest);
        float count = 0, begin = 0;
        for (const auto& pair : crowd_->pairs().subspan(next_pair_)) {
            if (pair.limit <= last || begin > latest) break;
            if (is_there(pair)) begin = std::max(begin, pair.limit + ++count);
        }
        is_urgent_ = begin > latest;
        const auto spare = static_cast<std::size_t>(std::max(latest - begin, 0.0F));
        const std::size_t removals = is_urgent_ ? urgent : std::min(longest, spare + shortest);
        next_plan_ = stay - std::min(stay, removals - 1);
    }

    float without_wanted(std::uint32_t i) const { return (*crowd_)(i) + kSurplusWeight * surplus_->actual(i); }
    float excess(std::uint32_t i, float remaining) const { return without_wanted(i) - remaining * wanted_[i]; }

    /// Returns the point in [begin, end) with the largest excess. The excess of a point is the crowding by near points
    /// plus the weighted surplus. `bounds_` stores earlier values of the excess without the wanted part of the surplus.
    /// A step only removes points, so these values never increase, and outdated ones are still upper bounds.
    /// @param remaining  number of points that remain in the domain
    std::uint32_t most_crowded(std::uint32_t begin, std::uint32_t end, float remaining) {
        Ints found;
        with_lanes([&](auto) CCDT_INLINE { find_largest(begin, end, remaining, found); });
        std::uint32_t most = begin;
        float largest = kNone;
        const auto look_at = [&](std::uint32_t i) {
            bounds_[i] = without_wanted(i);
            const float own = bounds_[i] - remaining * wanted_[i];
            if (own < largest || (own == largest && i > most)) return;
            largest = own;
            most = i;
        };
        for (std::uint32_t lane = 0; lane < kLanes; ++lane) look_at(static_cast<std::uint32_t>(found[lane]));
        for (std::uint32_t i = begin; i < end; ++i) {
            if (bounds_[i] - remaining * wanted_[i] > largest) look_at(i);
        }
        return most;
    }

    /// Finds, for each lane, the point with the largest upper bound of its excess. A lane has every eighth point.
    CCDT_INLINE void find_largest(std::uint32_t begin, std::uint32_t end, float remaining, Ints& found) const {
        Floats most = Floats{} + kNone;
        found = Ints{} + static_cast<std::int32_t>(begin);
        for (std::uint32_t i = begin; i < end; i += kLanes) {
            const Ints each = EightLanes::from(i);
            Floats bounds, wanted;
            EightLanes::load(bounds_[i], bounds);
            EightLanes::load(wanted_[i], wanted);
            const Floats bound = bounds - remaining * wanted;
            const Ints more = (bound > most) & (each < static_cast<std::int32_t>(end));
            most = more ? bound : most;
            found = more ? each : found;
        }
    }

    void remove(std::uint32_t i) {
        is_present_[i] = 0;
        bounds_[i] = kNone;
        crowd_->remove(i);
        surplus_->remove(i);
        const auto region = std::ranges::upper_bound(begins_, i) - begins_.begin() - 1;
        regions_.count_removal(depth_, static_cast<std::size_t>(region));
    }

    void keep_rest() {
        std::size_t kept = 0;
        for (std::size_t i = 0; i < remaining_.size(); ++i) {
            if (is_present_[i] != 0) remaining_[kept++] = remaining_[i];
        }
        remaining_.resize(kept);
    }

    PointBox<P> frame_;
    Points<P> points_;              ///< [n] in the frame
    std::vector<double> spacings_;  ///< [n] local spacings
    double widest_;                 ///< limit on the reach of a pair relative to a point's own reach
    bool uniform_;
    Regions regions_;
    std::vector<std::uint32_t> remaining_;
    std::span<const P> reference_;  ///< places of points that represent the wanted density
    std::vector<P> sparse_;         ///< storage for reference_, except while reference_ refers to points_
    Executor& executor_;

    // State of the current step. It covers the points that remained at the beginning of the step.
    std::size_t target_ = 0;             ///< number of points that remain at the end of the step
    int depth_ = 0;                      ///< depth of the regions
    std::vector<std::uint32_t> begins_;  ///< start of each region
    Points<P> near_;
    std::vector<double> reaches_;
    std::optional<Crowding<P>> crowd_;
    std::vector<std::uint8_t> is_present_;
    std::optional<Surplus<P>> surplus_;
    std::vector<float> wanted_;  ///< wanted part of the weighted surplus, divided by the number of remaining points
    std::vector<float> bounds_;  ///< upper bounds of the excess without its wanted part
    std::size_t next_pair_ = 0;  ///< the nearest pair that remains
    std::size_t next_plan_ = 0;  ///< number of remaining points below which the next plan is made
    bool is_urgent_ = false;     ///< whether pairs must be separated before they are too near
};

/// Returns the spacing around each point.
/// @param even     whether all spacings are equal
/// @param uniform  whether the density is uniform, so that only borders change the spacing. Except in a solid domain,
///                 measured spacings then count only if they exceed the usual one by a tenth, because smaller
///                 differences are due to chance. In a solid domain, they are 0.94 to 0.97 times the usual one on
///                 average, far from the border, because 12 neighbours form a complete shell
template <class P>
std::vector<double> spacings_of(const PointBox<P>& frame, const Points<P>& points, bool even, bool uniform,
                                Executor& executor, const std::stop_token& stop) {
    constexpr double kByChance = 1.1;
    const double usual = frame.usual_spacing(points.size());
    std::vector<double> spacings(points.size(), usual);
    if (even) return spacings;
    const BasicCellList<P> near = frame.cells(points.positions);
    for_ranges(executor, points.size(), kStopStride, [&](std::size_t begin, std::size_t end) {
        if (stop.stop_requested()) return;
        SpacingMeter<P> meter(frame, points, near, usual);
        for (auto i = static_cast<std::uint32_t>(begin); i < end; ++i) {
            const double measured = meter(i);
            if (!uniform || frame.is_solid || measured > kByChance * usual) spacings[i] = measured;
        }
    });
    return spacings;
}

/// Clamps a coordinate, so that points opposite the chart's centre are not at infinity.
double clamped(double coordinate) {
    constexpr double kMaxCoordinate = 1'000;  // a circle of 13 km around the opposite point
    return std::clamp(coordinate, -kMaxCoordinate, kMaxCoordinate);
}

/// Length of a vector added to the sum of the points' directions, so that points all over the globe do not cancel out.
constexpr double kTilt = 1e-6;

/// Least side of the box around points, which is needed if they coincide or lie on a line or in a plane.
constexpr double kMinSide = 1e-9;

/// Orders points of a frame progressively.
template <class P>
std::vector<std::uint32_t> order_points(const PointBox<P>& frame, const Points<P>& unsorted, bool even, bool uniform,
                                        const std::stop_token& stop, Executor& executor) {
    std::vector<std::uint32_t> order;
    if (unsorted.size() == 0) return order;
    std::vector<std::uint32_t> numbers(unsorted.size());
    std::iota(numbers.begin(), numbers.end(), 0U);
    Regions regions(std::span<const P>(unsorted.positions), numbers);
    Points<P> points = unsorted.selected(numbers);
    std::vector<double> spacings = spacings_of(frame, points, even, uniform, executor, stop);

    Elimination<P> elimination(frame, std::move(points), std::move(spacings), even, uniform, std::move(regions),
                               executor);
    while (elimination.remaining().size() > 1 && !stop.stop_requested()) {
        const std::vector<std::uint32_t> removed = elimination.step(stop);
        order.insert(order.end(), removed.begin(), removed.end());
    }
    order.insert(order.end(), elimination.remaining().begin(), elimination.remaining().end());
    std::ranges::reverse(order);
    for (std::uint32_t& each : order) each = numbers[each];
    return order;
}

std::vector<std::uint32_t> order_positions(const Domain& domain, std::vector<Point> positions, bool uniform,
                                           const std::stop_token& stop, Executor& executor) {
    const PointBox<Point> frame{domain.unit_bounds().max, domain.unit_area(), domain.is_torus(), false, &domain};
    return order_points<Point>(frame, {std::move(positions), {}}, uniform && domain.is_torus(), uniform, stop,
                               executor);
}

}  // namespace

std::vector<std::uint32_t> progressive_order(const Domain& domain, std::span<const Point> points, bool uniform,
                                             const std::stop_token& stop, Executor& executor) {
    std::vector<Point> positions;
    positions.reserve(points.size());
    for (const Point p : points) positions.push_back(domain.to_unit(p));
    return order_positions(domain, std::move(positions), uniform, stop, executor);
}

std::vector<std::uint32_t> progressive_order_on_globe(std::span<const Point> points, const std::stop_token& stop,
                                                      Executor& executor) {
    if (points.empty()) return {};
    std::vector<Direction> directions;
    directions.reserve(points.size());
    Direction sum{0, 0, kTilt};
    for (const Point p : points) {
        directions.push_back(direction_of(p));
        sum = sum + directions.back();
    }
    const Chart chart(normalised(sum));
    std::vector<Point> positions;
    positions.reserve(points.size());
    for (const Direction d : directions) {
        const Point p = chart.to_plane(d);
        positions.push_back({clamped(p.x), clamped(p.y)});
    }
    Box box{positions.front(), positions.front()};
    for (const Point p : positions) box.include(p);
    const double side = std::max({box.width(), box.height(), kMinSide});
    const Domain square = Domain::rectangle(side, side).value();
    for (Point& p : positions) p = square.to_unit(p - box.min);
    return order_positions(square, std::move(positions), false, stop, executor);
}

std::vector<std::uint32_t> progressive_order_on_surface(std::span<const Point3> points, std::span<const Point3> normals,
                                                        double area, bool uniform, bool closed,
                                                        const std::stop_token& stop, Executor& executor) {
    assert(normals.size() == points.size());
    if (points.empty()) return {};
    const Box3 box = bounds_of(points);
    const Point3 sides = box.max - box.min;
    const PointBox<Point3> frame{
        {std::max(sides.x, kMinSide), std::max(sides.y, kMinSide), std::max(sides.z, kMinSide)}, area};
    Points<Point3> moved{{}, {normals.begin(), normals.end()}};
    moved.positions.reserve(points.size());
    for (const Point3 p : points) moved.positions.push_back(p - box.min);
    return order_points(frame, moved, uniform && closed, uniform, stop, executor);
}

std::vector<std::uint32_t> progressive_order_in_space(const Box3& box, bool is_torus, std::span<const Point3> points,
                                                      double share, bool uniform, const std::stop_token& stop,
                                                      Executor& executor) {
    const Point3 sides = box.max - box.min;
    const double scale = std::max({sides.x, sides.y, sides.z});
    const Point3 unit{sides.x / scale, sides.y / scale, sides.z / scale};
    const PointBox<Point3> frame{unit, share * unit.x * unit.y * unit.z, is_torus, true};
    Points<Point3> moved;
    for (const Point3 p : points) {
        const Point3 q = p - box.min;
        moved.positions.push_back({q.x / scale, q.y / scale, q.z / scale});
    }
    return order_points(frame, moved, uniform && is_torus, uniform, stop, executor);
}

}  // namespace ccdt
