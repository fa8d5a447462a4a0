// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/baselines/periodic_images.h"
#include "core/geometry/point.h"

namespace ccdt {

/// Finds sites near a point by a balanced k-d tree (Bentley 1975). Crowded sites do not affect the speed.
class SiteTree {
public:
    /// A site, and the position of one of its periodic copies (see PeriodicImages).
    struct Found {
        std::uint32_t site;
        Point position;
    };

    /// Builds the tree. O(n log n).
    /// @param sites  [n >= 1]
    SiteTree(std::span<const Point> sites, const PeriodicImages& images);

    /// Returns the nearest site that is not hidden; none if all are hidden. Mostly O(log n).
    /// @param position  on a torus: within the torus's box
    std::optional<Found> nearest(Point position) const;

    /// Finds all sites within a distance, hidden ones included. If `distance` is at least 2 r plus the distance to the
    /// nearest site, the result contains every site that can be nearest to some point within the distance r of
    /// `position`.
    /// @param position  on a torus: within the torus's box
    /// @param found     out; replaced
    void within(Point position, double distance, std::vector<Found>& found) const;

    /// Hides a site from nearest(). O(log n).
    void hide(std::uint32_t site);

private:
    struct Node {
        Box box;
        std::uint32_t begin, end;  ///< range of the node's sites in sites_
        std::uint32_t remaining;   ///< number of sites that are not hidden
    };

    void build(std::size_t node, std::uint32_t begin, std::uint32_t end);
    bool is_leaf(std::size_t node) const { return 2 * node + 1 >= nodes_.size(); }
    template <class Visit>
    void for_each_copy(Visit&& visit) const;
    void improve(std::size_t node, Point position, Point shift, double& best, std::optional<Found>& found) const;
    void collect(std::size_t node, Point position, Point shift, double limit, std::vector<Found>& found) const;

    PeriodicImages images_;
    std::vector<Node> nodes_;   ///< children of node k are 2 k + 1 and 2 k + 2
    std::vector<Found> sites_;  ///< in the order of the leaves; on a torus: within the torus's box
    std::vector<std::uint32_t> slot_of_;
    std::vector<bool> hidden_;  ///< [sites_] whether the site is hidden
};

}  // namespace ccdt
