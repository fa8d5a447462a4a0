#include "core/dotmap/feature_area.h"

#include <algorithm>
#include <cmath>

namespace ccdt {

FeatureArea::FeatureArea(const Domain& domain) : bounds_(domain.bounds()) {
    // One for the rounding of corners, and one for that of points.
    constexpr double kRoundings = 2;
    margin_ = kRoundings * domain.resolution() * std::max(bounds_.width(), bounds_.height());
    std::vector<Edge> all;
    double heights = 0;
    for (const Ring& ring : domain.rings()) {
        for (std::size_t i = 0; i < ring.size(); ++i) {
            const Point a = domain.to_user(ring[i]), b = domain.to_user(ring[(i + 1) % ring.size()]);
            all.push_back(a.y <= b.y ? Edge{a, b} : Edge{b, a});
            heights += std::abs(b.y - a.y);
        }
    }
    // As many rows as there may be, if each edge is in four of them on the average.
    constexpr double kEach = 4;
    const double spans = std::max(heights / bounds_.height(), kEach);
    const auto rows = static_cast<std::size_t>(1 + kEach * static_cast<double>(all.size()) / spans);
    row_height_ = bounds_.height() / static_cast<double>(rows);
    first_.assign(rows + 1, 0);
    const auto for_rows = [&](const Edge& edge, auto visit) {
        const std::size_t last = row_of(edge.high.y + margin_);
        for (std::size_t row = row_of(edge.low.y - margin_); row <= last; ++row) visit(row);
    };
    for (const Edge& edge : all) for_rows(edge, [&](std::size_t row) { ++first_[row + 1]; });
    for (std::size_t row = 0; row < rows; ++row) first_[row + 1] += first_[row];
    edges_.resize(first_.back());
    auto next = first_;
    for (const Edge& edge : all) for_rows(edge, [&](std::size_t row) { edges_[next[row]++] = edge; });
}

std::size_t FeatureArea::row_of(double y) const {
    const double row = std::floor((y - bounds_.min.y) / row_height_);
    return static_cast<std::size_t>(std::clamp(row, 0.0, static_cast<double>(first_.size() - 2)));
}

bool FeatureArea::contains(Point p) const {
    if (!(p.x > bounds_.min.x && p.x < bounds_.max.x && p.y > bounds_.min.y && p.y < bounds_.max.y)) return false;
    const std::size_t row = row_of(p.y);
    bool inside = false;
    for (std::size_t i = first_[row]; i < first_[row + 1]; ++i) {
        const auto& [a, b] = edges_[i];
        if (p.y < a.y - margin_ || p.y > b.y + margin_) continue;
        const auto [west, east] = std::minmax(a.x, b.x);
        if (p.x > east + margin_) continue;
        const bool crosses = (a.y <= p.y) != (b.y <= p.y);
        if (p.x < west - margin_) {
            inside ^= crosses;
            continue;
        }
        const Point along = b - a;
        const double left = cross(along, p - a);
        if (left * left <= margin_ * margin_ * dot(along, along)) return false;
        inside ^= crosses && left > 0;
    }
    return inside;
}

/// The edge that the way meets first; null if there is none.
/// @param at  out: where on the way, in [0, 1]
const FeatureArea::Edge* FeatureArea::first_crossed(Point from, Point to, double& at) const {
    const Edge* found = nullptr;
    const Point way = to - from;
    at = 1;
    const std::size_t low = row_of(std::min(from.y, to.y)), high = row_of(std::max(from.y, to.y));
    for (std::size_t i = first_[low]; i < first_[high + 1]; ++i) {
        const Edge& edge = edges_[i];
        const Point along = edge.high - edge.low, off = edge.low - from;
        const double turn = cross(way, along);
        if (turn == 0) continue;
        const double on_way = cross(off, along) / turn, on_edge = cross(off, way) / turn;
        if (on_way < 0 || on_way > at || on_edge < 0 || on_edge > 1) continue;
        at = on_way;
        found = &edge;
    }
    return found;
}

Point FeatureArea::towards(Point from, Point to) const {
    if (contains(to)) return to;
    double at = 1;
    const Edge* border = first_crossed(from, to, at);
    if (border == nullptr) return from;
    const Point along = border->high - border->low, way = to - from;
    const Point slid = from + dot(way, along) / dot(along, along) * along;
    if (contains(slid)) return slid;
    const Point half = from + at / 2 * way;
    return contains(half) ? half : from;
}

}  // namespace ccdt
