// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/maps/outlines.h"

#include <bit>
#include <cmath>
#include <cstdint>

#include "core/ccdt/globe/turns.h"

namespace ccdt {

namespace {

template <class Visit>
void for_rings(std::span<const PolygonPart> feature, const Visit& visit) {
    for (const PolygonPart& part : feature) {
        visit(part.outer);
        for (const Ring& hole : part.holes) visit(hole);
    }
}

template <class Visit>
void for_edges(const Ring& ring, const Visit& visit) {
    for (std::size_t i = 0; i < ring.size(); ++i) {
        const Point a = ring[i], b = ring[(i + 1) % ring.size()];
        if (a != b) visit(a, b);
    }
}

}  // namespace

std::size_t Outlines::Hash::operator()(const Edge& edge) const {
    std::uint64_t hash = 0;
    for (const double value : {edge.first.x, edge.first.y, edge.second.x, edge.second.y})
        hash = (hash ^ std::bit_cast<std::uint64_t>(value + 0.0)) * 0x9e3779b97f4a7c15 ^ hash >> 29;
    return hash;
}

Outlines::Edge Outlines::edge_between(Point a, Point b) const {
    const Point way = b - a;
    if (way.x < 0 || (way.x == 0 && way.y < 0)) return edge_between(b, a);
    if (projection_ != nullptr) {
        a.x = std::remainder(a.x, kTurn);
        if (a.x == -kTurn / 2) a.x = kTurn / 2;
    }
    return {a, way};
}

/// Returns the edges that lie on both sides of the antimeridian.
std::unordered_set<Outlines::Edge, Outlines::Hash> Outlines::find_cuts(std::span<const PolygonPart> feature) const {
    std::unordered_set<Edge, Hash> once, twice;
    if (projection_ == nullptr) return twice;
    for_rings(feature, [&](const Ring& ring) {
        for_edges(ring, [&](Point a, Point b) {
            if (a.x != b.x || std::abs(std::remainder(a.x, kTurn)) != kTurn / 2) return;
            const Edge edge = edge_between(a, b);
            if (!once.insert(edge).second) twice.insert(edge);
        });
    });
    return twice;
}

void Outlines::trace(std::span<const PolygonPart> feature, const LineSink& sink) {
    traced_.merge(find_cuts(feature));
    for_rings(feature, [&](const Ring& ring) { trace(ring, sink); });
}

void Outlines::trace(const Ring& ring, const LineSink& sink) {
    for_edges(ring, [&](Point a, Point b) {
        const bool is_pole = projection_ != nullptr && a.y == b.y && std::abs(a.y) == 90;
        if (is_pole || !traced_.insert(edge_between(a, b)).second) return lift(sink);
        if (!is_drawing_) move_to(projection_ == nullptr ? a : (*projection_)(a), sink);
        if (projection_ == nullptr) return line_to(b, sink);
        projection_->trace_edge(
            a, b, [&](Point p) { line_to(p, sink); },
            [&](Point p) {
                lift(sink);
                move_to(p, sink);
            });
    });
    lift(sink);
}

void Outlines::move_to(Point corner, const LineSink& sink) {
    sink(corner, true);
    last_ = corner;
    is_drawing_ = true;
}

void Outlines::line_to(Point corner, const LineSink& sink) {
    skipped_ = corner;
    is_skipped_ = dot(corner - last_, corner - last_) < tolerance_ * tolerance_;
    if (is_skipped_) return;
    sink(corner, false);
    last_ = corner;
}

/// Ends the line, at its last corner even if that was left out.
void Outlines::lift(const LineSink& sink) {
    if (is_drawing_ && is_skipped_) sink(skipped_, false);
    is_drawing_ = is_skipped_ = false;
}

}  // namespace ccdt
