// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/baselines/voronoi_cells.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "core/baselines/site_tree.h"

namespace ccdt {

namespace {

double squared_distance(Point a, Point b) {
    return dot(a - b, a - b);
}

Point centre_of(const Part& part) {
    return 1.0 / 3 * (part.corners[0] + part.corners[1] + part.corners[2]);
}

/// Clips a convex polygon to the points nearer to one site than to another (Sutherland and Hodgman 1974).
void clip_at_bisector(std::span<const Point> polygon, Point site, Point other, std::vector<Point>& clipped) {
    clipped.clear();
    const Point way = other - site, middle = 0.5 * (site + other);
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Point a = polygon[i], b = polygon[i + 1 < polygon.size() ? i + 1 : 0];
        const double beyond_a = dot(a - middle, way), beyond_b = dot(b - middle, way);
        if (beyond_a <= 0) clipped.push_back(a);
        if ((beyond_a <= 0) != (beyond_b <= 0)) clipped.push_back(a + beyond_a / (beyond_a - beyond_b) * (b - a));
    }
}

}  // namespace

/// The integration for one set of sites.
class VoronoiCells::Integration {
public:
    Integration(const VoronoiCells& domain, std::span<const Point> sites, const std::stop_token& stop)
        : domain_(domain),
          tree_(sites, domain.images_),
          stop_(stop),
          tiny_(kTinyShare * domain.total_ / static_cast<double>(sites.size())),
          cells_(sites.size()) {}

    std::vector<Moments> run();

private:
    static constexpr double kTinyShare = 1e-3;  // relative to the mean mass per site

    void find_near(const Part& part);
    void divide(const Part& part, std::size_t begin, int depth);
    void narrow_down(const Part& part, std::size_t begin);
    void clip(const Part& part, std::size_t begin);

    const VoronoiCells& domain_;
    SiteTree tree_;
    const std::stop_token& stop_;
    double tiny_;  ///< mass below which a part is not divided
    std::vector<Moments> cells_;

    /// A stack of sites: the sites that can be nearest to some point of a part, then the sites for one half of this
    /// part, and so on.
    std::vector<SiteTree::Found> near_;
    std::vector<Point> polygon_, clipped_;
    std::size_t clips_ = 0;
    bool stopped_ = false;
};

std::vector<Moments> VoronoiCells::Integration::run() {
    for (const Part& part : domain_.parts_) {
        find_near(part);
        divide(part, 0, 0);
    }
    return std::move(cells_);
}

void VoronoiCells::Integration::find_near(const Part& part) {
    constexpr double kRounding = 1e-9;
    const Point centre = centre_of(part);
    double radius = 0;
    for (const Point& corner : part.corners) radius = std::max(radius, squared_distance(centre, corner));
    const double nearest = std::sqrt(squared_distance(tree_.nearest(centre)->position, centre));
    tree_.within(centre, (1 + kRounding) * (nearest + 2 * std::sqrt(radius)), near_);
}

/// Adds the integrals over a part to the cells. Halves the part if many sites can be nearest to its points.
/// @param begin  index in near_ of the first site near the part
void VoronoiCells::Integration::divide(const Part& part, std::size_t begin, int depth) {
    constexpr std::size_t kFew = 6;
    constexpr int kMaxDepth = 60;
    if (stopped_ || !(part.mass() > 0)) return;
    const std::size_t end = near_.size();
    narrow_down(part, begin);
    const bool is_tiny = part.mass() < tiny_ || depth == kMaxDepth;
    if (near_.size() - end > kFew && is_tiny) near_.resize(end + 1);
    if (near_.size() - end <= kFew) {
        clip(part, end);
    } else {
        for (const Part& half : domain_.bisection_.halves(part)) divide(half, end, depth + 1);
    }
    near_.resize(end);
}

/// Selects, among the sites of near_ from `begin` on, those that can be nearest to a point of the part, and appends
/// them to near_. The first appended site is nearest to the centre of the part. Each further site is nearer to some
/// corner of the part than the first site.
void VoronoiCells::Integration::narrow_down(const Part& part, std::size_t begin) {
    const std::size_t end = near_.size();
    const Point centre = centre_of(part);
    std::size_t nearest = begin;
    double least = squared_distance(near_[begin].position, centre);
    for (std::size_t i = begin; i < end; ++i) {
        const double squared = squared_distance(near_[i].position, centre);
        nearest = squared < least ? i : nearest;
        least = std::min(squared, least);
    }
    const SiteTree::Found first = near_[nearest];
    near_.push_back(first);
    for (std::size_t i = begin; i < end; ++i) {
        const SiteTree::Found site = near_[i];
        const Point way = site.position - first.position, middle = 0.5 * (site.position + first.position);
        const auto is_nearer = [&](Point corner) { return dot(corner - middle, way) > 0; };
        if (i != nearest && std::ranges::any_of(part.corners, is_nearer)) near_.push_back(site);
    }
}

void VoronoiCells::Integration::clip(const Part& part, std::size_t begin) {
    constexpr std::size_t kStopStride = 4096;
    if (++clips_ % kStopStride == 0) stopped_ = stop_.stop_requested();
    for (std::size_t i = begin; i < near_.size(); ++i) {
        polygon_.assign(part.corners.begin(), part.corners.end());
        for (std::size_t j = begin; j < near_.size() && !polygon_.empty(); ++j) {
            if (j == i) continue;
            clip_at_bisector(polygon_, near_[i].position, near_[j].position, clipped_);
            polygon_.swap(clipped_);
        }
        cells_[near_[i].site].add(domain_.weight_.over(polygon_, near_[i].position));
    }
}

VoronoiCells::VoronoiCells(const Domain& domain, const Triangulation& mesh, const Density& density)
    : images_(domain),
      bisection_(domain, density),
      weight_(domain, density),
      parts_(bisection_.parts_of(domain, mesh)) {
    for (const Part& part : parts_) total_ += part.mass();
}

std::vector<Moments> VoronoiCells::integrate(std::span<const Point> sites, const std::stop_token& stop) const {
    return Integration(*this, sites, stop).run();
}

}  // namespace ccdt
