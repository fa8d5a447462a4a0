// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/geometry/apportion.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <tuple>

#include "core/base/random.h"

namespace ccdt {

namespace {

constexpr std::uint32_t kNone = ~std::uint32_t{0};
constexpr double kRounding = 1e-10;  ///< relative errors of sums of quotas; nearer sums are whole

double square(Point3 p) {
    return dot(p, p);
}

/// A place that has a quota.
struct Place {
    Point3 position;
    std::uint32_t number;  ///< index among all places
};

/// A node of a binary tree of places. Each child holds one half of the places of its parent. Nodes are in preorder, so
/// the first child follows its parent.
struct PlaceNode {
    Point3 centre;        ///< of the bounding box
    double variance = 0;  ///< mean squared distance of the places from the centre
    double radius = 0;    ///< largest distance of a place from the centre
    std::uint32_t parent = kNone;
    std::uint32_t second = kNone;  ///< second child; none for a leaf
    std::uint32_t place = kNone;   ///< of a leaf: number of its place
    double quota = 0;              ///< sum over the classes that have been rounded, or are being rounded
    double count = 0;              ///< sum over the same classes

    bool is_leaf() const { return second == kNone; }
};

Box3 bounds_of(std::span<const Place> places) {
    Box3 box{places.front().position, places.front().position};
    for (const Place& place : places) {
        const Point3 p = place.position;
        box.min = {std::min(box.min.x, p.x), std::min(box.min.y, p.y), std::min(box.min.z, p.z)};
        box.max = {std::max(box.max.x, p.x), std::max(box.max.y, p.y), std::max(box.max.z, p.z)};
    }
    return box;
}

/// Lists the places that have a quota, scaled into the unit cube, so that squares of distances are in range.
std::vector<Place> used_places(std::span<const Point3> positions, std::span<const std::vector<double>> quotas) {
    std::vector<Place> places;
    for (std::uint32_t i = 0; i < positions.size(); ++i) {
        if (std::ranges::any_of(quotas, [i](const auto& of_class) { return of_class[i] > 0; }))
            places.push_back({0.5 * positions[i], i});  // differences of halves are finite
    }
    if (places.empty()) return places;
    const Box3 box = bounds_of(places);
    const Point3 sides = box.max - box.min;
    const double longest = std::max({sides.x, sides.y, sides.z});
    for (Place& place : places) {
        const Point3 off = place.position - box.min;
        if (longest > 0) place.position = {off.x / longest, off.y / longest, off.z / longest};
    }
    return places;
}

/// Appends the tree of some places, which are reordered.
void append_tree(std::span<Place> places, std::uint32_t parent, std::vector<PlaceNode>& nodes) {
    const auto self = static_cast<std::uint32_t>(nodes.size());
    const Box3 box = bounds_of(places);
    const Point3 sides = box.max - box.min;
    PlaceNode& node = nodes.emplace_back();
    node.parent = parent;
    node.centre = 0.5 * (box.min + box.max);
    for (const Place& place : places) {
        const double squared = square(place.position - node.centre);
        node.variance += squared / static_cast<double>(places.size());
        node.radius = std::max(node.radius, std::sqrt(squared));
    }
    if (places.size() == 1) {
        node.place = places.front().number;
        return;
    }
    const std::size_t longest = sides.x >= std::max(sides.y, sides.z) ? 0 : sides.y >= sides.z ? 1 : 2;
    const std::size_t half = places.size() / 2;
    std::ranges::nth_element(places, places.begin() + static_cast<std::ptrdiff_t>(half), {}, [&](const Place& place) {
        const auto& [x, y, z] = place.position;
        const std::array<double, 3> along = {x, y, z};
        return std::tuple(along[longest], along[(longest + 1) % 3], along[(longest + 2) % 3], place.number);
    });
    append_tree(places.first(half), self, nodes);
    nodes[self].second = static_cast<std::uint32_t>(nodes.size());
    append_tree(places.subspan(half), self, nodes);
}

/// Rounds the quotas of one class.
class ClassRounding {
public:
    /// @param number  number of the class; the nodes of the tree hold the sums of earlier classes
    ClassRounding(std::vector<PlaceNode>& nodes, std::span<const double> quotas, std::uint64_t number)
        : nodes_(nodes), number_(number), own_(nodes.size()) {
        for (std::uint32_t i = size(); i-- > 0;) {
            const PlaceNode& node = nodes_[i];
            own_[i].quota = node.is_leaf() ? quotas[node.place] : own_[i + 1].quota + own_[node.second].quota;
            nodes_[i].quota += own_[i].quota;
            bound(i);
        }
    }

    /// Writes the counts of all places in the tree.
    void execute(std::span<std::size_t> counts) {
        add(0, std::clamp(std::round(own_[0].quota), own_[0].least, own_[0].most));
        for (std::uint32_t i = 0; i < size(); ++i) {
            if (own_[i].quota > kCell) divide(i);
        }
        even_out();
        for (std::uint32_t i = 0; i < size(); ++i) {
            if (own_[i].quota <= kCell) divide(i);
            if (nodes_[i].is_leaf()) counts[nodes_[i].place] = static_cast<std::size_t>(own_[i].count);
        }
    }

private:
    static constexpr double kCell = 1.0 / 16;  // a square cell is a quarter as wide as the spacing of units
    static constexpr double kNear = 16;        // units within reach of a cell's kernel, at most one per cell
    static constexpr int kPasses = 3;
    static constexpr double kMinGain = 1e-9;         // above rounding errors
    static constexpr std::size_t kMaxVisits = 1024;  // per cell, for places that are spread extremely unevenly

    /// Numbers of a node, for this class.
    struct Own {
        double quota = 0;
        double least = 0, most = 0;  ///< bounds of the count
        double count = 0;
        double units = 0;  ///< sum over the cells of the quota, at most 1 for each cell
        double reach = 0;  ///< largest reach of the cells
        std::uint32_t first_cell = 0, cells = 0;
    };

    /// A leaf, or the highest node of its branch with a quota of at most kCell; its quota is not 0.
    struct Cell {
        Point3 centre;
        double reach = 0;      ///< radius of the kernel
        double potential = 0;  ///< sum over the cells of error() times kernel
        std::uint32_t node = 0;
    };

    std::uint32_t size() const { return static_cast<std::uint32_t>(nodes_.size()); }
    bool is_cell(std::uint32_t i) const { return own_[i].quota <= kCell || nodes_[i].is_leaf(); }

    /// Sets the bounds of a node's count, after those of its children.
    void bound(std::uint32_t i) {
        Own& own = own_[i];
        const double whole = std::round(own.quota);
        const bool is_whole = std::abs(own.quota - whole) <= kRounding * own.quota;
        own.least = is_whole ? whole : std::floor(own.quota);
        own.most = is_whole ? whole : std::ceil(own.quota);
        if (nodes_[i].is_leaf()) return;
        const Own &first = own_[i + 1], &second = own_[nodes_[i].second];
        own.least = std::max(own.least, first.least + second.least);
        own.most = std::min(own.most, first.most + second.most);
    }

    void add(std::uint32_t i, double change) {
        own_[i].count += change;
        nodes_[i].count += change;
    }

    /// Divides the count of a node between its children. The error of the node is divided in proportion to the quotas.
    void divide(std::uint32_t i) {
        const PlaceNode& node = nodes_[i];
        if (node.is_leaf() || own_[i].count == 0) return;
        const std::uint32_t first = i + 1;
        const Own &whole = own_[i], &left = own_[first], &right = own_[node.second];
        const double own = whole.count * (left.quota / whole.quota);
        const double all = node.count * (nodes_[first].quota / node.quota) - nodes_[first].count;
        const double least = std::max(left.least, whole.count - right.most);
        const double most = std::min(left.most, whole.count - right.least);
        const double count = std::clamp(std::floor((own + all) / 2 + Random(number_, i).uniform()), least, most);
        add(node.second, whole.count - count);
        add(first, count);
    }

    /// Moves units between cells.
    void even_out() {
        find_cells();
        for (std::size_t i = 0; i < cells_.size(); ++i) {
            visit(i, [&](std::size_t other, double kernel) { cells_[i].potential += kernel * error(other); });
        }
        bool any = true;
        for (int pass = 0; pass < kPasses && any; ++pass) {
            any = false;
            for (std::size_t i = 0; i < cells_.size(); ++i) any |= move(i);
        }
    }

    /// Lists the cells in the order of the nodes, and chooses their kernels.
    void find_cells() {
        for (std::uint32_t i = 0; i < size(); ++i) {
            own_[i].first_cell = static_cast<std::uint32_t>(cells_.size());
            const bool is_highest = i == 0 || !is_cell(nodes_[i].parent);
            if (is_cell(i) && is_highest && own_[i].quota > 0) cells_.push_back({nodes_[i].centre, 0, 0, i});
        }
        for (std::uint32_t i = size(); i-- > 0;) {
            Own& own = own_[i];
            const bool is_inner = !is_cell(i);
            own.units = is_inner ? own_[i + 1].units + own_[nodes_[i].second].units : std::min(1.0, own.quota);
            own.cells = is_inner ? own_[i + 1].cells + own_[nodes_[i].second].cells : own.quota > 0 ? 1 : 0;
        }
        for (Cell& cell : cells_) set_reach(cell);
    }

    /// Returns the mean of the errors of this class and of all classes. A move changes both by the same number.
    double error(std::size_t cell) const {
        const std::uint32_t i = cells_[cell].node;
        return (own_[i].count - own_[i].quota + nodes_[i].count - nodes_[i].quota) / 2;
    }

    /// Chooses a radius within which there are about kNear units. A square of width w has the variance w^2 / 6.
    void set_reach(Cell& cell) {
        std::uint32_t around = cell.node;
        while (around > 0 && own_[around].units < kNear) around = nodes_[around].parent;
        const double area_of_unit = 6 * nodes_[around].variance / own_[around].units;
        cell.reach = std::sqrt(kNear * area_of_unit / std::numbers::pi);
        for (std::uint32_t i = cell.node; i != kNone && own_[i].reach < cell.reach; i = nodes_[i].parent)
            own_[i].reach = cell.reach;
    }

    /// Calls `call(other, kernel)` for the cells around a cell. The kernel of two cells has the larger of their radii.
    template <class Call>
    void visit(std::size_t cell, Call&& call, std::uint32_t from = 0) {
        constexpr std::uint32_t kBlock = 8;  // cells that are visited one after the other
        const Cell own = cells_[cell];
        const Own& node = own_[from];
        if (node.cells > kBlock) {
            const double reach = std::max(own.reach, node.reach) + nodes_[from].radius;
            if (square(nodes_[from].centre - own.centre) >= reach * reach) return;
            visit(cell, call, from + 1);
            visit(cell, call, nodes_[from].second);
            return;
        }
        visits_ += node.cells;
        if (is_exhausted()) return;
        for (std::uint32_t i = node.first_cell; i < node.first_cell + node.cells; ++i) {
            const double squared = square(cells_[i].centre - own.centre);
            const double reach = std::max(own.reach, cells_[i].reach);
            if (squared >= reach * reach) continue;
            const double left = 1 - std::sqrt(squared) / reach;
            call(i, left * left);
        }
    }

    bool is_exhausted() const { return visits_ > kMaxVisits * cells_.size(); }

    /// Moves a unit from a cell to the one where the energy becomes least. Returns whether any move reduces the energy.
    bool move(std::size_t cell) {
        const std::uint32_t from = cells_[cell].node;
        if (own_[from].count <= own_[from].least || is_exhausted()) return false;
        double gain = kMinGain;
        std::size_t best = cell;
        visit(cell, [&](std::size_t other, double kernel) {
            const double own = cells_[cell].potential - cells_[other].potential - (1 - kernel);
            if (own <= gain || !may_move(from, cells_[other].node)) return;
            gain = own;
            best = other;
        });
        if (best == cell) return false;
        for_path(from, cells_[best].node, [&](std::uint32_t i, double change) {
            add(i, change);
            return true;
        });
        visit(cell, [&](std::size_t other, double kernel) { cells_[other].potential -= kernel; });
        visit(best, [&](std::size_t other, double kernel) { cells_[other].potential += kernel; });
        return true;
    }

    /// Whether all sums stay within their bounds when a unit moves.
    bool may_move(std::uint32_t from, std::uint32_t to) const {
        return for_path(from, to, [&](std::uint32_t i, double change) {
            const double count = own_[i].count + change, error = nodes_[i].count - nodes_[i].quota;
            return count >= own_[i].least && count <= own_[i].most && error * change < 0;
        });
    }

    /// Calls `call(node, change)` for the nodes whose counts a move changes, until it returns false.
    template <class Call>
    bool for_path(std::uint32_t from, std::uint32_t to, Call&& call) const {
        while (from != to) {
            std::uint32_t& lower = from > to ? from : to;  // in preorder, neither is above the other
            if (!call(lower, from > to ? -1.0 : 1.0)) return false;
            lower = nodes_[lower].parent;
        }
        return true;
    }

    std::vector<PlaceNode>& nodes_;
    std::uint64_t number_;
    std::vector<Own> own_;
    std::vector<Cell> cells_;
    std::size_t visits_ = 0;
};

}  // namespace

std::vector<std::vector<std::size_t>> apportion(std::span<const Point3> places,
                                                std::span<const std::vector<double>> quotas) {
    std::vector<Place> used = used_places(places, quotas);
    std::vector<PlaceNode> nodes;
    if (!used.empty()) append_tree(used, kNone, nodes);
    std::vector<std::vector<std::size_t>> counts(quotas.size(), std::vector<std::size_t>(places.size()));
    for (std::size_t i = 0; i < quotas.size() && !nodes.empty(); ++i)
        ClassRounding(nodes, quotas[i], i).execute(counts[i]);
    return counts;
}

}  // namespace ccdt
