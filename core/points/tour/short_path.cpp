// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/points/tour/short_path.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <initializer_list>
#include <limits>
#include <numeric>
#include <utility>

#include "core/geometry/delaunay.h"

namespace ccdt {
namespace {

using Stop = std::uint32_t;  ///< a point, numbered along Hilbert's curve

constexpr std::size_t kMaxNeighbours = 8;
constexpr std::uint32_t kMaxChange = 25'000;  ///< number of stops that one improvement may move in memory
constexpr std::uint32_t kMaxRun = 3;          ///< largest number of stops that are relocated together
constexpr double kMinGain = 1e-12;            ///< relative to the points' extent; smaller gains may be rounding errors
constexpr std::size_t kStopStride = 256;      ///< stops between polls of the stop token

/// Returns the position of a point of the unit square along Hilbert's curve, with 24 bits per coordinate.
std::uint64_t hilbert_key(Point p) {
    constexpr std::uint32_t kSide = 1U << 24;
    auto x = static_cast<std::uint32_t>(p.x * (kSide - 1));
    auto y = static_cast<std::uint32_t>(p.y * (kSide - 1));
    std::uint64_t key = 0;
    for (std::uint32_t half = kSide / 2; half > 0; half /= 2) {
        const bool right = (x & half) != 0;
        const bool upper = (y & half) != 0;
        key = key << 2 | (right ? (upper ? 2U : 3U) : (upper ? 1U : 0U));
        if (upper) continue;
        if (right) {
            x = ~x;
            y = ~y;
        }
        std::swap(x, y);
    }
    return key;
}

/// Returns the points translated and scaled into the unit square.
std::vector<Point> normalised(std::span<const Point> points) {
    Box box{points.front(), points.front()};
    for (const Point& p : points) box.include(p);
    const double extent = std::max({box.width(), box.height(), std::numeric_limits<double>::min()});
    std::vector<Point> result;
    result.reserve(points.size());
    for (const Point& p : points) result.push_back({(p.x - box.min.x) / extent, (p.y - box.min.y) / extent});
    return result;
}

std::vector<std::uint32_t> along_hilbert(std::span<const Point> points) {
    std::vector<std::pair<std::uint64_t, std::uint32_t>> keyed;
    keyed.reserve(points.size());
    for (const Point& p : points) keyed.emplace_back(hilbert_key(p), static_cast<std::uint32_t>(keyed.size()));
    std::sort(keyed.begin(), keyed.end());
    std::vector<std::uint32_t> order(points.size());
    std::transform(keyed.begin(), keyed.end(), order.begin(), [](const auto& each) { return each.second; });
    return order;
}

double distance(Point a, Point b) {
    return std::sqrt(dot(a - b, a - b));
}

/// The nearest neighbours of each point in the Delaunay triangulation, sorted by distance.
class Neighbours {
public:
    Neighbours(std::span<const Point> points, const std::stop_token& stop) : begins_(points.size() + 1) {
        const auto triangulation = constrained_delaunay(points, {}, stop);
        const auto count = static_cast<std::uint32_t>(points.size());
        const auto for_each_edge = [&](auto&& take) {
            for (const auto& triangle : triangulation->triangles) {
                for (std::size_t i = 0; i < 3; ++i) {
                    const std::uint32_t from = triangle.corners[i];
                    const std::uint32_t to = triangle.corners[(i + 1) % 3];
                    if (from < count && to < count) take(from, to);
                }
            }
        };
        for_each_edge([this](std::uint32_t from, std::uint32_t) { ++begins_[from + 1]; });
        std::partial_sum(begins_.begin(), begins_.end(), begins_.begin());
        lists_.resize(begins_.back());
        std::vector<std::uint32_t> ends(begins_.begin(), begins_.end() - 1);
        for_each_edge([&](std::uint32_t from, std::uint32_t to) { lists_[ends[from]++] = to; });
        for (std::uint32_t from = 0; from < count; ++from) {
            if (from % kStopStride == 0 && stop.stop_requested()) return;
            sort(points, from);
        }
    }

    std::span<const Stop> of(Stop stop) const {
        const auto all = std::span(lists_).subspan(begins_[stop], begins_[stop + 1] - begins_[stop]);
        return all.first(std::min(all.size(), kMaxNeighbours));
    }

private:
    void sort(std::span<const Point> points, std::uint32_t from) {
        const auto key = [&](std::uint32_t to) { return std::pair(distance(points[from], points[to]), to); };
        std::sort(lists_.begin() + begins_[from], lists_.begin() + begins_[from + 1],
                  [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
    }

    std::vector<std::uint32_t> begins_;  ///< [n + 1] start of each list in lists_
    std::vector<Stop> lists_;
};

/// A closed tour, stored as an array.
class Tour {
public:
    explicit Tour(std::uint32_t size) : stops_(size), positions_(size) {
        std::iota(stops_.begin(), stops_.end(), 0U);
        std::iota(positions_.begin(), positions_.end(), 0U);
    }

    std::uint32_t size() const { return static_cast<std::uint32_t>(stops_.size()); }
    Stop next(Stop stop) const { return at(positions_[stop] + 1); }
    Stop previous(Stop stop) const { return at(positions_[stop] + size() - 1); }

    /// Returns the number of steps forward from one stop to another.
    std::uint32_t steps(Stop from, Stop to) const { return wrapped(positions_[to] + size() - positions_[from]); }

    /// Reverses the order of the stops from `first` forward to `last`.
    /// @returns  false if that would move too many stops; the tour is then unchanged
    bool reverse(Stop first, Stop last) {
        std::uint32_t inner = steps(first, last) + 1;
        if (2 * inner > size()) {  // reversing the other stops instead makes the same tour
            const Stop after = next(last);
            last = previous(first);
            first = after;
            inner = size() - inner;
        }
        if (inner > kMaxChange) return false;
        std::uint32_t i = positions_[first];
        std::uint32_t j = positions_[last];
        for (std::uint32_t k = 0; k < inner / 2; ++k) {
            const Stop left = stops_[i];
            put(stops_[j], i);
            put(left, j);
            i = wrapped(i + 1);
            j = wrapped(j + size() - 1);
        }
        return true;
    }

    /// Removes a run of stops and inserts it after another stop.
    /// @param first   first stop of the run
    /// @param length  number of stops in the run
    /// @param after   not in the run
    /// @param turned  whether the run is reversed
    /// @returns       false if that would move too many stops; the tour is then unchanged
    bool move(Stop first, std::uint32_t length, Stop after, bool turned) {
        std::array<Stop, kMaxRun> run{};
        for (std::uint32_t i = 0; i < length; ++i) run[i] = at(positions_[first] + i);
        const std::uint32_t ahead = steps(run[length - 1], after);
        const std::uint32_t behind = size() - length - ahead;
        if (std::min(ahead, behind) > kMaxChange) return false;
        std::uint32_t position = positions_[first];
        if (ahead <= behind) {
            for (std::uint32_t k = 0; k < ahead; ++k, position = wrapped(position + 1))
                put(at(position + length), position);
        } else {
            for (std::uint32_t k = 0; k < behind; ++k) {
                position = wrapped(position + size() - 1);
                put(stops_[position], wrapped(position + length));
            }
        }
        if (turned) std::reverse(run.begin(), run.begin() + length);
        for (std::uint32_t i = 0; i < length; ++i) put(run[i], wrapped(position + i));
        return true;
    }

private:
    /// @param position  < 2 * size
    std::uint32_t wrapped(std::uint32_t position) const { return position < size() ? position : position - size(); }
    Stop at(std::uint32_t position) const { return stops_[wrapped(position)]; }
    void put(Stop stop, std::uint32_t position) {
        stops_[position] = stop;
        positions_[stop] = position;
    }

    std::vector<Stop> stops_;               ///< stop at each position
    std::vector<std::uint32_t> positions_;  ///< position of each stop
};

/// A queue of stops whose surroundings have changed, without duplicates.
class Queue {
public:
    explicit Queue(std::uint32_t size) : ring_(size), waiting_(size, true), count_(size) {
        std::iota(ring_.begin(), ring_.end(), 0U);
    }

    bool empty() const { return count_ == 0; }

    void push(Stop stop) {
        if (waiting_[stop]) return;
        waiting_[stop] = true;
        ring_[(first_ + count_++) % ring_.size()] = stop;
    }

    Stop pop() {
        const Stop stop = ring_[first_];
        first_ = (first_ + 1) % ring_.size();
        --count_;
        waiting_[stop] = false;
        return stop;
    }

private:
    std::vector<Stop> ring_;
    std::vector<bool> waiting_;
    std::size_t first_ = 0;
    std::size_t count_;
};

/// Shortens a closed tour or an open path. A path is stored as a closed tour with an extra stop, the gap, at distance 0
/// from every stop. The ends of the path are adjacent to the gap.
class Shortener {
public:
    Shortener(std::span<const Point> points, const Neighbours& neighbours, bool closed)
        : points_(points),
          neighbours_(neighbours),
          gap_(static_cast<Stop>(points.size())),
          closed_(closed),
          tour_(closed ? gap_ : gap_ + 1),
          queue_(gap_) {}

    void run(const std::stop_token& stop) {
        for (std::size_t i = 0; !queue_.empty(); ++i) {
            if (i % kStopStride == 0 && stop.stop_requested()) return;
            const Stop each = queue_.pop();
            while (exchange(each) || relocate(each)) {
            }
        }
    }

    std::vector<Stop> path() const {
        std::vector<Stop> path;
        path.reserve(points_.size());
        for (Stop stop = closed_ ? 0 : tour_.next(gap_); path.size() < points_.size(); stop = tour_.next(stop))
            path.push_back(stop);
        return path;
    }

private:
    double way(Stop a, Stop b) const { return a == gap_ || b == gap_ ? 0 : distance(points_[a], points_[b]); }

    void revisit(std::initializer_list<Stop> stops) {
        for (const Stop stop : stops) {
            if (stop != gap_) queue_.push(stop);
        }
    }

    /// Tries the 2-opt step: replaces the edges a-b and c-d by the edges a-c and b-d. The stop c is near a. The stops b
    /// and d are the next stops after a and c, or else the previous stops.
    /// @returns  whether a step shortened the path
    bool exchange(Stop a) {
        for (const bool forward : {true, false}) {
            const auto beside = [&](Stop stop) { return forward ? tour_.next(stop) : tour_.previous(stop); };
            const Stop b = beside(a);
            const double left = way(a, b);
            for (const Stop c : neighbours_.of(a)) {
                const double joined = way(a, c);
                if (joined >= left) break;
                const Stop d = beside(c);
                if (left + way(c, d) - joined - way(b, d) < kMinGain) continue;
                if (!(forward ? tour_.reverse(b, c) : tour_.reverse(a, d))) continue;
                revisit({a, b, c, d});
                return true;
            }
        }
        return false;
    }

    /// Tries the Or-opt step: removes a run of stops that begins or ends with `a`, and inserts it again beside a stop
    /// near `a`.
    /// @returns  whether a step shortened the path
    bool relocate(Stop a) {
        Stop forward = a;
        Stop backward = a;
        for (std::uint32_t length = 1; length <= kMaxRun && length + 2 < tour_.size(); ++length) {
            if (relocate(a, a, forward, length)) return true;
            if (length > 1 && relocate(a, backward, a, length)) return true;
            forward = tour_.next(forward);
            backward = tour_.previous(backward);
        }
        return false;
    }

    /// Tries to move a run of stops to a position beside a stop near `a`.
    /// @param a            the run's first or last stop, which becomes adjacent to the nearby stop
    /// @param first, last  ends of the run
    /// @param length       number of stops in the run
    bool relocate(Stop a, Stop first, Stop last, std::uint32_t length) {
        const Stop before = tour_.previous(first);
        const Stop behind = tour_.next(last);
        const Stop other = a == first ? last : first;
        const double saved = way(before, first) + way(last, behind) - way(before, behind);
        const auto in_run = [&](Stop stop) { return tour_.steps(first, stop) < length; };
        for (const Stop c : neighbours_.of(a)) {
            const double joined = way(a, c);
            if (joined >= saved) break;
            if (in_run(c)) continue;
            for (const bool ahead : {true, false}) {
                const Stop d = ahead ? tour_.next(c) : tour_.previous(c);
                if (in_run(d) || saved - joined - way(other, d) + way(c, d) < kMinGain) continue;
                const bool turned = ahead ? a != first : a == first;
                if (!tour_.move(first, length, ahead ? c : d, turned)) continue;
                revisit({before, behind, a, other, c, d});
                return true;
            }
        }
        return false;
    }

    std::span<const Point> points_;
    const Neighbours& neighbours_;
    Stop gap_;  ///< in no closed tour
    bool closed_;
    Tour tour_;
    Queue queue_;
};

/// @param closed  whether the way from the last point to the first counts
std::vector<std::uint32_t> short_order(std::span<const Point> points, bool closed, const std::stop_token& stop) {
    if (points.empty()) return {};
    const std::vector<Point> unit = normalised(points);
    std::vector<std::uint32_t> start = along_hilbert(unit);
    // In this order, points near in the plane are near in memory.
    std::vector<Point> sorted(unit.size());
    std::transform(start.begin(), start.end(), sorted.begin(), [&](std::uint32_t i) { return unit[i]; });
    if (stop.stop_requested()) return start;
    const Neighbours neighbours(sorted, stop);
    if (stop.stop_requested()) return start;
    Shortener shortener(sorted, neighbours, closed);
    shortener.run(stop);
    std::vector<std::uint32_t> path = shortener.path();
    for (std::uint32_t& each : path) each = start[each];
    return path;
}

}  // namespace

std::vector<std::uint32_t> short_path(std::span<const Point> points, const std::stop_token& stop) {
    return short_order(points, false, stop);
}

std::vector<std::uint32_t> short_tour(std::span<const Point> points, const std::stop_token& stop) {
    return short_order(points, true, stop);
}

double path_length(std::span<const Point> points) {
    double length = 0;
    for (std::size_t i = 1; i < points.size(); ++i) length += distance(points[i - 1], points[i]);
    return length;
}

}  // namespace ccdt
