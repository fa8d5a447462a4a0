// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/baselines/site_tree.h"

#include <algorithm>
#include <limits>

namespace ccdt {

namespace {

constexpr std::uint32_t kLeaf = 6;  // sites per leaf

double squared_distance(Point a, Point b) {
    return dot(a - b, a - b);
}

double squared_distance(const Box& box, Point p) {
    const Point off{std::max({box.min.x - p.x, p.x - box.max.x, 0.0}),
                    std::max({box.min.y - p.y, p.y - box.max.y, 0.0})};
    return dot(off, off);
}

}  // namespace

SiteTree::SiteTree(std::span<const Point> sites, const PeriodicImages& images)
    : images_(images), slot_of_(sites.size()), hidden_(sites.size(), false) {
    const auto count = static_cast<std::uint32_t>(sites.size());
    for (std::uint32_t i = 0; i < count; ++i) sites_.push_back({i, images.in_box(sites[i])});
    std::size_t leaves = 1;
    while (leaves * kLeaf < count) leaves *= 2;
    nodes_.resize(2 * leaves - 1);
    build(0, 0, count);
    for (std::uint32_t slot = 0; slot < count; ++slot) slot_of_[sites_[slot].site] = slot;
}

void SiteTree::build(std::size_t node, std::uint32_t begin, std::uint32_t end) {
    Box box{sites_[begin].position, sites_[begin].position};
    for (std::uint32_t i = begin; i < end; ++i) {
        const Point p = sites_[i].position;
        box.min = {std::min(box.min.x, p.x), std::min(box.min.y, p.y)};
        box.max = {std::max(box.max.x, p.x), std::max(box.max.y, p.y)};
    }
    nodes_[node] = {box, begin, end, end - begin};
    if (is_leaf(node)) return;
    const std::uint32_t middle = begin + (end - begin) / 2;
    const bool wide = box.width() > box.height();
    std::nth_element(
        sites_.begin() + begin, sites_.begin() + middle, sites_.begin() + end, [wide](const Found& a, const Found& b) {
            const double first = wide ? a.position.x : a.position.y, second = wide ? b.position.x : b.position.y;
            return first != second ? first < second : a.site < b.site;
        });
    build(2 * node + 1, begin, middle);
    build(2 * node + 2, middle, end);
}

/// Calls visit(shift) for the periodic copies of the box that can contain the nearest copy of a site. The box itself
/// comes first.
template <class Visit>
void SiteTree::for_each_copy(Visit&& visit) const {
    visit(Point{0, 0});
    if (!images_.is_torus()) return;
    const Point period = images_.period();
    for (const int y : {-1, 0, 1}) {
        for (const int x : {-1, 0, 1}) {
            if (x != 0 || y != 0) visit(Point{x * period.x, y * period.y});
        }
    }
}

std::optional<SiteTree::Found> SiteTree::nearest(Point position) const {
    double best = std::numeric_limits<double>::infinity();
    std::optional<Found> found;
    for_each_copy([&](Point shift) { improve(0, position - shift, shift, best, found); });
    return found;
}

void SiteTree::improve(std::size_t node, Point position, Point shift, double& best, std::optional<Found>& found) const {
    const Node& here = nodes_[node];
    if (here.remaining == 0 || squared_distance(here.box, position) >= best) return;
    if (!is_leaf(node)) {
        const std::size_t first = 2 * node + 1;
        const bool swap =
            squared_distance(nodes_[first + 1].box, position) < squared_distance(nodes_[first].box, position);
        improve(swap ? first + 1 : first, position, shift, best, found);
        improve(swap ? first : first + 1, position, shift, best, found);
        return;
    }
    for (std::uint32_t slot = here.begin; slot < here.end; ++slot) {
        const double distance = squared_distance(sites_[slot].position, position);
        if (hidden_[slot] || distance >= best) continue;
        best = distance;
        found = Found{sites_[slot].site, sites_[slot].position + shift};
    }
}

void SiteTree::within(Point position, double distance, std::vector<Found>& found) const {
    found.clear();
    for_each_copy([&](Point shift) { collect(0, position - shift, shift, distance * distance, found); });
}

void SiteTree::collect(std::size_t node, Point position, Point shift, double limit, std::vector<Found>& found) const {
    const Node& here = nodes_[node];
    if (squared_distance(here.box, position) > limit) return;
    if (!is_leaf(node)) {
        collect(2 * node + 1, position, shift, limit, found);
        collect(2 * node + 2, position, shift, limit, found);
        return;
    }
    for (std::uint32_t slot = here.begin; slot < here.end; ++slot) {
        if (squared_distance(sites_[slot].position, position) > limit) continue;
        found.push_back({sites_[slot].site, sites_[slot].position + shift});
    }
}

void SiteTree::hide(std::uint32_t site) {
    const std::uint32_t slot = slot_of_[site];
    hidden_[slot] = true;
    for (std::size_t node = 0;;) {
        --nodes_[node].remaining;
        if (is_leaf(node)) return;
        node = 2 * node + (slot < nodes_[2 * node + 1].end ? 1 : 2);
    }
}

}  // namespace ccdt
