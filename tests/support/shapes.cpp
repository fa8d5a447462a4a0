// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/support/shapes.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <set>
#include <utility>

#include <nlohmann/json.hpp>

#include "core/geometry/predicates.h"

namespace ccdt::test {

namespace {

Ring read_ring(const nlohmann::json& json) {
    Ring ring;
    for (const auto& vertex : json) ring.push_back({vertex.at(0).get<double>(), vertex.at(1).get<double>()});
    return ring;
}

PolygonPart read_part(const nlohmann::json& json) {
    PolygonPart part{read_ring(json.at(0)), {}};
    for (std::size_t i = 1; i < json.size(); ++i) part.holes.push_back(read_ring(json[i]));
    return part;
}

template <class Change>
Parts changed(Parts parts, Change&& change) {
    for (PolygonPart& part : parts) {
        for (Point& p : part.outer) p = change(p);
        for (Ring& hole : part.holes) {
            for (Point& p : hole) p = change(p);
        }
    }
    return parts;
}

/// Toggles `inside` for each edge to the right of p that crosses its height. Returns true if p is on the ring.
bool cross_ring(const Ring& ring, Point p, bool& inside) {
    for (std::size_t i = 0; i < ring.size(); ++i) {
        const Point a = ring[i], b = ring[(i + 1) % ring.size()];
        if (std::max(a.y, b.y) < p.y || std::min(a.y, b.y) > p.y || std::max(a.x, b.x) < p.x) continue;
        const int side = orientation(a, b, p);
        if (side == 0 && p.x >= std::min(a.x, b.x)) return true;
        if ((a.y <= p.y) != (b.y <= p.y) && (side > 0) == (b.y > a.y)) inside = !inside;
    }
    return false;
}

}  // namespace

Ring box(double x, double y, double width, double height) {
    return {{x, y}, {x + width, y}, {x + width, y + height}, {x, y + height}};
}

Ring star(Point centre, double outer, double inner, int corners) {
    Ring ring;
    for (int i = 0; i < corners; ++i) {
        const double angle = 6.283185307179586 * i / corners, radius = i % 2 == 0 ? outer : inner;
        ring.push_back(centre + radius * Point{std::cos(angle), std::sin(angle)});
    }
    return ring;
}

Ring circle(Point centre, double radius, int corners) {
    return star(centre, radius, radius, corners);
}

Ring l_shape() {
    return {{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}};
}

Ring u_shape() {
    return {{0, 0}, {4, 0}, {4, 4}, {3, 4}, {3, 1}, {1, 1}, {1, 4}, {0, 4}};
}

PolygonPart sieve(int count) {
    PolygonPart part{box(0, 0, 1, 1), {}};
    const double pitch = 1.0 / count;
    for (int j = 0; j < count; ++j) {
        for (int i = 0; i < count; ++i) {
            part.holes.push_back(box((i + 0.25) * pitch, (j + 0.25) * pitch, pitch / 2, pitch / 2));
        }
    }
    return part;
}

Parts read_geojson(const std::string& name) {
    std::ifstream file(std::string(CCDT_TEST_DATA) + "/polygons/" + name);
    const auto json = nlohmann::json::parse(file);
    Parts parts;
    if (json.at("type") == "Polygon") return {read_part(json.at("coordinates"))};
    for (const auto& part : json.at("coordinates")) parts.push_back(read_part(part));
    return parts;
}

Parts scaled(Parts parts, double factor) {
    return changed(std::move(parts), [&](Point p) { return factor * p; });
}

Parts moved(Parts parts, Point by) {
    return changed(std::move(parts), [&](Point p) { return p + by; });
}

bool contains(const Parts& parts, Point p) {
    if (!std::isfinite(p.x) || !std::isfinite(p.y)) return false;
    const auto is_in = [p](const Ring& ring, bool with_border) {
        bool inside = false;
        return cross_ring(ring, p, inside) ? with_border : inside;
    };
    return std::ranges::any_of(parts, [&](const PolygonPart& part) {
        return is_in(part.outer, false) &&
               std::ranges::none_of(part.holes, [&](const Ring& hole) { return is_in(hole, true); });
    });
}

double distance_to_border(const Parts& parts, Point p) {
    double least = std::numeric_limits<double>::infinity();
    const auto look_at = [&](const Ring& ring) {
        for (std::size_t i = 0; i < ring.size(); ++i) {
            const Point a = ring[i], ab = ring[(i + 1) % ring.size()] - a;
            const double share = dot(ab, ab) > 0 ? std::clamp(dot(p - a, ab) / dot(ab, ab), 0.0, 1.0) : 0;
            const Point away = p - (a + share * ab);
            least = std::min(least, std::sqrt(dot(away, away)));
        }
    };
    for (const PolygonPart& part : parts) {
        look_at(part.outer);
        for (const Ring& hole : part.holes) look_at(hole);
    }
    return least;
}

std::size_t count_outside(const Parts& parts, const std::vector<Point>& points) {
    return static_cast<std::size_t>(
        std::count_if(points.begin(), points.end(), [&](Point p) { return !contains(parts, p); }));
}

std::size_t count_distinct(const std::vector<Point>& points) {
    std::set<std::pair<double, double>> distinct;
    for (const Point& p : points) distinct.insert({p.x, p.y});
    return distinct.size();
}

}  // namespace ccdt::test
