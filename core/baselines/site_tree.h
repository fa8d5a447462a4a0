#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/baselines/periodic_images.h"
#include "core/geometry/point.h"

namespace ccdt {

/// Finds sites near a place: a balanced k-d tree (Bentley 1975), as quick where sites crowd as where they are few.
class SiteTree {
public:
    /// A site, in one of its copies.
    struct Found {
        std::uint32_t site;
        Point place;
    };

    /// Builds the tree. O(n log n)
    /// @param sites  [n >= 1]
    SiteTree(std::span<const Point> sites, const PeriodicImages& images);

    /// The site nearest to a place, of those not taken away; nothing if all are. O(log n), mostly.
    /// @param place  on a torus within its box
    std::optional<Found> nearest(Point place) const;

    /// Sites within a distance of a place, taken away or not; all that may be nearest to any place within half that
    /// distance, if `distance` is at least twice that to the nearest one.
    /// @param place  on a torus within its box
    /// @param found  out, replaced
    void within(Point place, double distance, std::vector<Found>& found) const;

    /// Hides a site from nearest(). O(log n)
    void take_away(std::uint32_t site);

private:
    struct Node {
        Box box;
        std::uint32_t begin, end;  ///< of its sites in sites_
        std::uint32_t left;        ///< not taken away
    };

    void build(std::size_t node, std::uint32_t begin, std::uint32_t end);
    bool is_leaf(std::size_t node) const { return 2 * node + 1 >= nodes_.size(); }
    template <class Visit>
    void for_each_copy(Visit&& visit) const;
    void improve(std::size_t node, Point place, Point shift, double& best, std::optional<Found>& found) const;
    void collect(std::size_t node, Point place, Point shift, double limit, std::vector<Found>& found) const;

    PeriodicImages images_;
    std::vector<Node> nodes_;   ///< children of k are 2 k + 1 and 2 k + 2
    std::vector<Found> sites_;  ///< in the order of the leaves, on a torus within its box
    std::vector<std::uint32_t> slot_of_;
    std::vector<bool> taken_;  ///< by slot
};

}  // namespace ccdt
