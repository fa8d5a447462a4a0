// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/maps/feature_area.h"

#include <algorithm>
#include <cmath>

namespace ccdt {

FeatureArea::FeatureArea(const Domain& domain, const Clearance& clearance, std::size_t cells)
    : bounds_(domain.bounds()) {
    // Allows for the rounding of corners and of points.
    constexpr double kRoundings = 2;
    margin_ = kRoundings * domain.resolution() * std::max(bounds_.width(), bounds_.height());
    std::vector<Edge> all;
    double heights = 0;
    for (const Ring& ring : domain.rings()) {
        for (std::size_t i = 0; i < ring.size(); ++i) {
            const Point a = domain.to_user(ring[i]), b = domain.to_user(ring[(i + 1) % ring.size()]);
            const Point along = b - a;
            const double length = std::sqrt(dot(along, along));
            const double clear = clearance ? clearance(0.5 * (a + b), 1 / length * Point{-along.y, along.x}) : 0;
            all.push_back({a.y <= b.y ? a : b, a.y <= b.y ? b : a, std::max(clear, margin_), length});
            heights += std::abs(b.y - a.y);
        }
    }
    // The number of rows is the largest for which an edge lies in at most four rows on average.
    constexpr double kEach = 4;
    const double spans = std::max(heights / bounds_.height(), kEach);
    const auto rows = static_cast<std::size_t>(1 + kEach * static_cast<double>(all.size()) / spans);
    row_height_ = bounds_.height() / static_cast<double>(rows);
    first_.assign(rows + 1, 0);
    const auto for_rows = [&](const Edge& edge, auto visit) {
        const std::size_t last = row_of(edge.high.y + edge.clearance);
        for (std::size_t row = row_of(edge.low.y - edge.clearance); row <= last; ++row) visit(row);
    };
    for (const Edge& edge : all) for_rows(edge, [&](std::size_t row) { ++first_[row + 1]; });
    for (std::size_t row = 0; row < rows; ++row) first_[row + 1] += first_[row];
    edges_.resize(first_.back());
    auto next = first_;
    for (const Edge& edge : all) for_rows(edge, [&](std::size_t row) { edges_[next[row]++] = edge; });
    if (cells > 0) make_grid(all, spans, cells);
}

/// Finds the cells that no edge comes near, and determines which of these cells lie inside.
/// @param crossings  mean number of edges that cross a row
void FeatureArea::make_grid(const std::vector<Edge>& edges, double crossings, std::size_t cells) {
    const double each = static_cast<double>(cells), shape = bounds_.width() / bounds_.height();
    const double rows = std::floor(std::clamp(std::sqrt(each / shape), 1.0, std::max(1.0, each / crossings)));
    const double columns = std::floor(each / rows);
    grid_rows_ = static_cast<std::size_t>(rows);
    grid_columns_ = static_cast<std::size_t>(columns);
    rows_per_unit_ = rows / bounds_.height();
    columns_per_unit_ = columns / bounds_.width();
    if (!std::isfinite(rows_per_unit_) || !std::isfinite(columns_per_unit_)) return;
    grid_.assign(grid_rows_ * grid_columns_, Cell::Outside);
    for (const Edge& edge : edges) mark(edge);
    const auto middle = [&](std::size_t column, std::size_t row) {
        return bounds_.min + Point{(static_cast<double>(column) + 0.5) / columns * bounds_.width(),
                                   (static_cast<double>(row) + 0.5) / rows * bounds_.height()};
    };
    for (std::size_t row = 0; row < grid_rows_; ++row) {
        Cell run = Cell::Near;  // state of the current run of cells that no edge separates
        for (std::size_t column = 0; column < grid_columns_; ++column) {
            Cell& cell = grid_[row * grid_columns_ + column];
            if (cell != Cell::Near && run == Cell::Near) {
                run = position_of(middle(column, row)) == Position::Inside ? Cell::Inside : Cell::Outside;
            }
            if (cell == Cell::Near) {
                run = Cell::Near;
            } else {
                cell = run;
            }
        }
    }
}

/// Marks the cells within the clearance of an edge.
void FeatureArea::mark(const Edge& edge) {
    constexpr double kRounding = 1e-6;  // relative to a cell
    const auto& [low, high, clearance, length] = edge;
    const double height = bounds_.height() / static_cast<double>(grid_rows_);
    const double above = clearance + kRounding * height;
    const double beside = clearance + kRounding * bounds_.width() / static_cast<double>(grid_columns_);
    const Point along = high - low;
    const auto [west, east] = std::minmax(low.x, high.x);
    const std::size_t last = grid_row(high.y + above);
    for (std::size_t row = grid_row(low.y - above); row <= last; ++row) {
        const double bottom = bounds_.min.y + static_cast<double>(row) * height;
        double from = west, to = east;
        if (along.y > above) {  // the part of the edge near the row
            const double in = std::clamp((bottom - above - low.y) / along.y, 0.0, 1.0);
            const double out = std::clamp((bottom + height + above - low.y) / along.y, 0.0, 1.0);
            from = low.x + (along.x > 0 ? in : out) * along.x;
            to = low.x + (along.x > 0 ? out : in) * along.x;
        }
        const std::size_t end = grid_column(to + beside);
        for (std::size_t column = grid_column(from - beside); column <= end; ++column)
            grid_[row * grid_columns_ + column] = Cell::Near;
    }
}

std::size_t FeatureArea::row_of(double y) const {
    const double row = std::floor((y - bounds_.min.y) / row_height_);
    return static_cast<std::size_t>(std::clamp(row, 0.0, static_cast<double>(first_.size() - 2)));
}

/// Returns the position of a point relative to the area.
/// @param near  out: if the result is Margin, an edge whose clearance contains the point
FeatureArea::Position FeatureArea::position_of(Point p, const Edge*& near) const {
    if (!(p.x > bounds_.min.x && p.x < bounds_.max.x && p.y > bounds_.min.y && p.y < bounds_.max.y))
        return Position::Outside;
    if (is_far_inside(p)) return Position::Inside;
    const std::size_t row = row_of(p.y);
    bool inside = false;
    for (std::size_t i = first_[row]; i < first_[row + 1]; ++i) {
        const Edge& edge = edges_[i];
        const auto& [a, b, clearance, length] = edge;
        if (p.y < a.y - clearance || p.y > b.y + clearance) continue;
        const auto [west, east] = std::minmax(a.x, b.x);
        if (p.x > east + clearance) continue;
        const bool crosses = (a.y <= p.y) != (b.y <= p.y);
        if (p.x < west - clearance) {
            inside ^= crosses;
            continue;
        }
        const Point along = b - a;
        const double left = cross(along, p - a);
        if (std::abs(left) <= clearance * length) {
            const bool at_edge = p.y >= a.y - margin_ && p.y <= b.y + margin_ && p.x <= east + margin_ &&
                                 p.x >= west - margin_ && std::abs(left) <= margin_ * length;
            if (at_edge) return Position::Outside;
            near = &edge;
        }
        inside ^= crosses && left > 0;
    }
    if (!inside) return Position::Outside;
    return near == nullptr ? Position::Inside : Position::Margin;
}

/// Returns the edge that the path from one point to another crosses first; null if there is none.
/// @param at  out: position of the crossing on the path, in [0, 1]
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
    const Edge* border = nullptr;
    const Position there = position_of(to, border);
    if (there == Position::Inside) return to;
    const bool is_free = position_of(from) == Position::Margin;
    if (is_free && there == Position::Margin) return to;
    const auto allows = [&](Point p) {
        const Position position = position_of(p);
        return position == Position::Inside || (is_free && position == Position::Margin);
    };
    double at = 1;
    if (there == Position::Outside) border = first_crossed(from, to, at);
    if (border == nullptr) return from;
    const Point along = border->high - border->low, way = to - from;
    const Point slid = from + dot(way, along) / dot(along, along) * along;
    if (allows(slid)) return slid;
    const Point half = from + at / 2 * way;
    return allows(half) ? half : from;
}

}  // namespace ccdt
