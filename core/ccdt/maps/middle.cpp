// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/maps/middle.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/ccdt/globe/chart.h"

namespace ccdt {

namespace {

Point3 position_of(Point p, bool on_globe) {
    if (!on_globe) return {p.x, p.y, 0};
    const Direction direction = direction_of({p.x, std::clamp(p.y, -90.0, 90.0)});
    return {direction.x, direction.y, direction.z};
}

double largest_coordinate(Point3 p) {
    return std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)});
}

}  // namespace

std::optional<Point3> middle_of(std::span<const PolygonPart> parts, bool on_globe) {
    constexpr double kMinArea = 1e-14;  // relative to a square as wide as the ring; smaller ones are rounding errors
    Point3 middle;
    double all = 0;
    for (const PolygonPart& part : parts) {
        if (part.outer.empty()) continue;
        const Point3 origin = position_of(part.outer.front(), on_globe);
        std::vector<Point3> corners;
        double width = 0;
        for (const Point& p : part.outer) {
            corners.push_back(position_of(p, on_globe) - origin);
            width = std::max(width, largest_coordinate(corners.back()));
        }
        if (!(width > 0)) continue;
        Point3 normal;
        for (Point3& corner : corners) corner = {corner.x / width, corner.y / width, corner.z / width};
        for (std::size_t i = 1; i < corners.size(); ++i) normal = normal + cross(corners[i - 1], corners[i]);
        const double size = length(normal);
        if (!(size > kMinArea)) continue;
        Point3 centroid;
        for (std::size_t i = 1; i < corners.size(); ++i) {
            const double share = dot(cross(corners[i - 1], corners[i]), normal) / size / size;
            centroid = centroid + (share / 3) * (corners[i - 1] + corners[i]);
        }
        const double area = size * width * width;
        all += area;
        middle = middle + (area / all) * (origin + width * centroid - middle);
    }
    const bool is_usable = all > 0 && std::isfinite(largest_coordinate(middle));
    return is_usable ? std::optional(middle) : std::nullopt;
}

}  // namespace ccdt
