#include "core/baselines/voronoi_cells.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace ccdt {

namespace {

double squared_distance(Point a, Point b) {
    return dot(a - b, a - b);
}

Point centre_of(const Part& part) {
    return 1.0 / 3 * (part.corners[0] + part.corners[1] + part.corners[2]);
}

/// The part of a convex polygon that is nearer to one site than to another (Sutherland and Hodgman 1974).
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

VoronoiCells::VoronoiCells(const Domain& domain, const Triangulation& mesh, const Density& density)
    : images_(domain),
      bisection_(domain, density),
      weight_(domain, density),
      parts_(bisection_.parts_of(domain, mesh)) {
    for (const Part& part : parts_) total_ += part.mass();
}

std::vector<Moments> VoronoiCells::integrate(std::span<const Point> sites, const std::stop_token& stop) {
    constexpr double kTinyShare = 1e-3;  // of what one site stands for
    cells_.assign(sites.size(), {});
    tiny_ = kTinyShare * total_ / static_cast<double>(sites.size());
    const SiteTree tree(sites, images_);
    for (const Part& part : parts_) {
        if (stop.stop_requested()) break;
        const Point centre = centre_of(part);
        double radius = 0;
        for (const Point& corner : part.corners) {
            radius = std::max(radius, std::sqrt(squared_distance(centre, corner)));
        }
        const double nearest = std::sqrt(squared_distance(tree.nearest(centre)->place, centre));
        tree.within(centre, (1 + 1e-9) * (nearest + 2 * radius), near_);
        divide(part, 0, 0);
    }
    return std::move(cells_);
}

/// @param begin  the part's sites are those in near_ from there on
void VoronoiCells::divide(const Part& part, std::size_t begin, int depth) {
    constexpr std::size_t kFew = 6;
    constexpr int kDeepest = 60;
    if (!(part.mass() > 0)) return;
    const std::size_t end = near_.size();
    narrow_down(part, begin);
    const bool is_tiny = part.mass() < tiny_ || depth == kDeepest;
    if (near_.size() - end > kFew && is_tiny) near_.resize(end + 1);
    if (near_.size() - end <= kFew) {
        clip(part, end);
    } else {
        for (const Part& half : bisection_.halves(part)) divide(half, end, depth + 1);
    }
    near_.resize(end);
}

/// Appends, of the sites in near_ from `begin` on, those that are somewhere in the part nearer than the one nearest to
/// its centre, which comes first.
void VoronoiCells::narrow_down(const Part& part, std::size_t begin) {
    const std::size_t end = near_.size();
    const Point centre = centre_of(part);
    std::size_t nearest = begin;
    for (std::size_t i = begin; i < end; ++i) {
        if (squared_distance(near_[i].place, centre) < squared_distance(near_[nearest].place, centre)) nearest = i;
    }
    const SiteTree::Found first = near_[nearest];
    near_.push_back(first);
    for (std::size_t i = begin; i < end; ++i) {
        const SiteTree::Found site = near_[i];
        const Point way = site.place - first.place, middle = 0.5 * (site.place + first.place);
        const auto is_nearer = [&](Point corner) { return dot(corner - middle, way) > 0; };
        if (i != nearest && std::ranges::any_of(part.corners, is_nearer)) near_.push_back(site);
    }
}

void VoronoiCells::clip(const Part& part, std::size_t begin) {
    for (std::size_t i = begin; i < near_.size(); ++i) {
        polygon_.assign(part.corners.begin(), part.corners.end());
        for (std::size_t j = begin; j < near_.size() && !polygon_.empty(); ++j) {
            if (j == i) continue;
            clip_at_bisector(polygon_, near_[i].place, near_[j].place, clipped_);
            polygon_.swap(clipped_);
        }
        cells_[near_[i].site].add(weight_.over(polygon_, near_[i].place));
    }
}

}  // namespace ccdt
