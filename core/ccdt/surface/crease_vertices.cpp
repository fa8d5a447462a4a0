// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/surface/crease_vertices.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <tuple>
#include <utility>

namespace ccdt {

namespace {

constexpr std::uint32_t kNone = Surface::kNone;

/// An edge on a border or crease, seen from one of its ends.
struct Step {
    std::uint32_t from, to;
    std::uint32_t edge;  ///< the half-edge with the smaller number
    bool reversed;       ///< whether the half-edge runs from `to` to `from`
};

/// Returns the distance of p from the segment ab.
double distance(Point3 p, Point3 a, Point3 b) {
    const Point3 along = b - a;
    const double squared = dot(along, along);
    const double share = squared > 0 ? std::clamp(dot(p - a, along) / squared, 0.0, 1.0) : 0;
    return length(p - a - share * along);
}

class Chooser {
public:
    Chooser(const Surface& surface, std::span<const double> spacings, std::size_t sites)
        : surface_(surface), spacings_(spacings) {
        list_steps();
        constexpr double kPerSite = 4, kAtLeast = 1000;  // largest number of vertices
        double count = 0;
        for (const Step& step : steps_)
            count += length(surface_.vertex(step.to) - surface_.vertex(step.from)) / 2 /
                     std::min(spacings_[step.from], spacings_[step.to]);
        widening_ = std::max(1.0, count / (kPerSite * static_cast<double>(sites) + kAtLeast));
    }

    CreaseVertices choose() {
        chosen_.corner.assign(surface_.vertex_count(), 0);
        done_.assign(steps_.size(), 0);
        for (std::uint32_t v = 0; v < surface_.vertex_count(); ++v) {
            if (degree(v) != 0 && degree(v) != 2) chosen_.corner[v] = 1;
        }
        for (std::uint32_t i = 0; i < steps_.size(); ++i) {
            if (chosen_.corner[steps_[i].from] != 0 && done_[i] == 0) divide(follow(i));
        }
        for (std::uint32_t i = 0; i < steps_.size(); ++i) {
            if (done_[i] == 0) divide(follow(i));  // a closed chain without corners
        }
        std::ranges::sort(chosen_.added, {}, [](const auto& each) { return std::pair(each.edge, each.share); });
        return std::move(chosen_);
    }

private:
    double spacing(std::uint32_t v) const { return widening_ * spacings_[v]; }

    /// Lists each edge twice, once from each end, sorted by the origin.
    void list_steps() {
        for (std::uint32_t f = 0; f < surface_.face_count(); ++f) {
            const auto corners = surface_.corners(f);
            for (std::uint32_t i = 0; i < 3; ++i) {
                const std::uint32_t h = 4 * f + i, twin = surface_.twin(h);
                if (!surface_.is_crease(h) || (twin != kNone && twin < h)) continue;
                const std::uint32_t a = corners[i], b = corners[(i + 1) % 3];
                steps_.push_back({a, b, h, false});
                steps_.push_back({b, a, h, true});
            }
        }
        std::ranges::sort(steps_, {}, [](const Step& step) { return std::tuple(step.from, step.edge, step.reversed); });
        first_.assign(surface_.vertex_count() + 1, 0);
        for (const Step& step : steps_) ++first_[step.from + std::size_t{1}];
        for (std::size_t v = 0; v + 1 < first_.size(); ++v) first_[v + 1] += first_[v];
    }

    std::uint32_t degree(std::uint32_t v) const { return first_[v + std::size_t{1}] - first_[v]; }

    /// Returns the chain that begins with a step. Marks its steps, in both directions.
    std::vector<Step> follow(std::uint32_t start) {
        std::vector<Step> chain;
        for (std::uint32_t i = start; i != kNone;) {
            const Step& step = steps_[i];
            chain.push_back(step);
            done_[i] = 1;
            std::uint32_t next = kNone;
            for (std::uint32_t k = first_[step.to]; k < first_[step.to + std::size_t{1}]; ++k) {
                if (steps_[k].edge == step.edge && steps_[k].reversed != step.reversed)
                    done_[k] = 1;
                else if (done_[k] == 0)
                    next = k;
            }
            i = chosen_.corner[step.to] != 0 ? kNone : next;
        }
        return chain;
    }

    Point3 position(const std::vector<Step>& chain, std::size_t i) const {
        return surface_.vertex(i < chain.size() ? chain[i].from : chain.back().to);
    }

    /// Marks the vertices of the simplified chain between two of its vertices (Ramer 1972; Douglas, Peucker 1973).
    void simplify(const std::vector<Step>& chain, std::size_t first, std::size_t last) {
        constexpr double kTolerance = 0.1;     // in local spacings
        constexpr std::size_t kStride = 1024;  // bounds the time, which can be quadratic
        std::vector<std::pair<std::size_t, std::size_t>> remaining;
        for (std::size_t begin = first; begin < last; begin += kStride) {
            if (begin > first) chosen_.corner[chain[begin].from] = 1;
            remaining.emplace_back(begin, std::min(begin + kStride, last));
        }
        while (!remaining.empty()) {
            const auto [begin, end] = remaining.back();
            remaining.pop_back();
            double farthest = 0;
            std::size_t at = begin;
            for (std::size_t i = begin + 1; i < end; ++i) {
                const double far =
                    distance(position(chain, i), position(chain, begin), position(chain, end)) / spacing(chain[i].from);
                if (far > farthest) farthest = far, at = i;
            }
            if (farthest <= kTolerance) continue;
            chosen_.corner[chain[at].from] = 1;
            remaining.emplace_back(begin, at);
            remaining.emplace_back(at, end);
        }
    }

    /// Chooses the vertices of a chain.
    void divide(const std::vector<Step>& chain) {
        constexpr double kMinVertices = 3;  // vertices of a closed chain
        const bool closed = chain.front().from == chain.back().to;
        std::size_t middle = chain.size();
        if (closed) {
            middle = 0;
            for (std::size_t i = 1; i < chain.size(); ++i) {
                const auto off = [&](std::size_t k) { return length(position(chain, k) - position(chain, 0)); };
                if (off(i) > off(middle)) middle = i;
            }
            chosen_.corner[chain.front().from] = chosen_.corner[chain[middle].from] = 1;
            simplify(chain, middle, chain.size());
        }
        if (middle > 0) simplify(chain, 0, middle);
        for (std::size_t begin = 0, end = 0; begin < chain.size(); begin = end) {
            std::vector<double> until{0};  // length of the chain in local spacings
            for (end = begin; end == begin || (end < chain.size() && chosen_.corner[chain[end].from] == 0); ++end) {
                const double local = (spacing(chain[end].from) + spacing(chain[end].to)) / 2;
                until.push_back(until.back() + length(position(chain, end + 1) - position(chain, end)) / local);
            }
            const double least = closed ? std::ceil(kMinVertices / 2) : 1;
            position_between(chain, begin, until, std::max(least, std::round(until.back())));
        }
    }

    /// Divides a part of a chain into pieces of equal length.
    /// @param until  [edges + 1] length up to each vertex of the part
    void position_between(const std::vector<Step>& chain, std::size_t begin, const std::vector<double>& until,
                          double pieces) {
        constexpr double kMinDistance =
            1e-3;  // distance from a vertex of the surface, relative to the edge and to a piece
        const double least = kMinDistance * until.back() / pieces;
        std::size_t i = 0;
        for (double k = 1; k < pieces; ++k) {
            const double at = until.back() * k / pieces;
            while (i + 2 < until.size() && until[i + 1] < at) ++i;
            const double side = until[i + 1] - until[i];
            const double share = side > 0 ? (at - until[i]) / side : 0;
            const Step& step = chain[begin + i];
            if (share < kMinDistance && at - until[i] < least)
                chosen_.corner[step.from] = 1;
            else if (share > 1 - kMinDistance && until[i + 1] - at < least)
                chosen_.corner[step.to] = 1;
            else
                chosen_.added.push_back({step.edge, step.reversed ? 1 - share : share});
        }
    }

    const Surface& surface_;
    std::span<const double> spacings_;
    double widening_;  ///< factor by which the spacings are increased
    std::vector<Step> steps_;
    std::vector<std::uint32_t> first_;  ///< [vertices + 1] first step from each vertex
    std::vector<std::uint8_t> done_;    ///< [steps]
    CreaseVertices chosen_;
};

}  // namespace

CreaseVertices choose_crease_vertices(const Surface& surface, std::span<const double> spacings, std::size_t sites) {
    return Chooser(surface, spacings, sites).choose();
}

}  // namespace ccdt
