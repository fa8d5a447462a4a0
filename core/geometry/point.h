#pragma once

namespace ccdt {

struct Point {
    double x = 0;
    double y = 0;

    friend bool operator==(const Point&, const Point&) = default;
    friend Point operator+(Point a, Point b) { return {a.x + b.x, a.y + b.y}; }
    friend Point operator-(Point a, Point b) { return {a.x - b.x, a.y - b.y}; }
    friend Point operator*(double s, Point a) { return {s * a.x, s * a.y}; }
};

inline double cross(Point a, Point b) {
    return a.x * b.y - a.y * b.x;
}
inline double dot(Point a, Point b) {
    return a.x * b.x + a.y * b.y;
}

/// An axis-parallel box, closed.
struct Box {
    Point min;
    Point max;

    double width() const { return max.x - min.x; }
    double height() const { return max.y - min.y; }
};

}  // namespace ccdt
