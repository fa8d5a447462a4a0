// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/surface/surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <numbers>
#include <string>
#include <utility>

#include "core/base/elementary.h"
#include "core/mesh/triangle_links.h"

namespace ccdt {

namespace {

using Links = TriangleLinks;

// Squares and products of lengths, and their sums, must be finite and keep full precision.
constexpr double kMinExtent = 1e-140, kMaxExtent = 1e140;
// Smallest extent relative to the magnitude of the coordinates; a smaller surface has too few distinct coordinates.
constexpr double kMinSize = 1e-9;
// Adding and subtracting it rounds to multiples of 2^-36.
constexpr double kRounder = 0x1p16;
// Share of the way to the centroid by which points on an edge are moved into their face.
constexpr double kInset = 1e-9;

double largest(Point3 p) {
    return std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)});
}

bool is_finite(Point3 p) {
    return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

/// A bounding box in space.
struct Extent {
    Point3 min{kInfinity, kInfinity, kInfinity};
    Point3 max{-kInfinity, -kInfinity, -kInfinity};

    static constexpr double kInfinity = std::numeric_limits<double>::infinity();

    void include(Point3 p) {
        min = {std::min(min.x, p.x), std::min(min.y, p.y), std::min(min.z, p.z)};
        max = {std::max(max.x, p.x), std::max(max.y, p.y), std::max(max.z, p.z)};
    }
    double size() const { return largest(max - min); }
    double magnitude() const { return std::max(largest(min), largest(max)); }
};

/// Returns the bounding box of the vertices that triangles use.
Result<Extent> find_extent(const TriangleSoup& soup) {
    Extent extent;
    for (std::size_t t = 0; t < soup.triangles.size(); ++t) {
        for (const std::uint32_t v : soup.triangles[t]) {
            if (is_finite(soup.vertices[v])) {
                extent.include(soup.vertices[v]);
                continue;
            }
            return failure(ErrorCode::Unusable,
                           "vertex " + std::to_string(v) + " of triangle " + std::to_string(t) +
                               " has a coordinate that is not finite",
                           "vertices/" + std::to_string(v));
        }
    }
    if (soup.triangles.empty()) return failure(ErrorCode::Unusable, "there are no triangles");
    const double size = extent.size();
    if (size == 0) return failure(ErrorCode::Unusable, "no triangle has an area");
    if (size >= kMinExtent && size <= kMaxExtent && size >= kMinSize * extent.magnitude()) return extent;
    return failure(ErrorCode::Unusable,
                   "the extent must be from 1e-140 to 1e140, and at least 1e-9 times the largest coordinate");
}

double squared(Point3 p) {
    return dot(p, p);
}

Point3 unit(Point3 p) {
    const double size = largest(p);
    if (size == 0) return {0, 0, 0};
    const Point3 scaled = 1 / size * p;
    return 1 / length(scaled) * scaled;
}

std::array<double, 3> mixed(const std::array<double, 3>& a, const std::array<double, 3>& b, double t) {
    return {(1 - t) * a[0] + t * b[0], (1 - t) * a[1] + t * b[1], (1 - t) * a[2] + t * b[2]};
}

std::array<double, 3> inset(const std::array<double, 3>& weights, double share) {
    return mixed(weights, {1. / 3, 1. / 3, 1. / 3}, share);
}

}  // namespace

/// The part of a traced line in one face. Coordinates in the face have their origin at the first corner of an edge, and
/// the x axis along this edge: edge 0 in the first face, and in later faces the edge where the line enters.
struct Surface::Walk {
    /// The smallest component of a direction that counts as different from 0.
    static constexpr double kMinComponent = 1e-12;

    std::uint32_t face = 0;
    double left = 0;                ///< distance left to go
    std::array<double, 3> entry{};  ///< weights of the position where the line enters the face
    double x = 0, y = 0;            ///< direction, of unit length

    std::uint32_t exit = 0;         ///< edge where the line leaves the face: 0, 1 or 2
    double t = 0;                   ///< position on this edge, from its first (0) to its second (1) corner
    double distance = 0;            ///< from the entry to the exit
    double edge_x = 0, edge_y = 0;  ///< vector from the second to the first corner of this edge

    std::array<double, 3> exit_weights() const {
        std::array<double, 3> weights{};
        weights[exit] = 1 - t;
        weights[Links::next(exit)] = t;
        return weights;
    }
};

struct Surface::Tree {
    std::once_flag once;
    std::optional<FaceTree> faces;  ///< built by the first call of tree()
};

Surface::Surface() = default;
Surface::Surface(Surface&&) noexcept = default;
Surface& Surface::operator=(Surface&&) noexcept = default;
Surface::~Surface() = default;

Result<Surface::Made> Surface::create(const TriangleSoup& soup, std::optional<double> crease,
                                      const std::stop_token& stop) {
    if (soup.triangles.size() > ConnectedTriangles::kMaxTriangles) {
        return failure(ErrorCode::LimitExceeded,
                       "there are more than " + std::to_string(ConnectedTriangles::kMaxTriangles) + " triangles");
    }
    const auto extent = find_extent(soup);
    if (!extent) return tl::unexpected(extent.error());
    Surface surface;
    surface.origin_ = extent->min;
    surface.scale_ = extent->size();

    const auto rounded = [](double value) { return (value + kRounder) - kRounder; };
    std::vector<Point3> positions(soup.vertices.size());
    for (std::size_t v = 0; v < positions.size(); ++v) {
        const Point3 p = surface.from_input(soup.vertices[v]);
        if (is_finite(p)) positions[v] = {rounded(p.x), rounded(p.y), rounded(p.z)};
    }
    auto connected = connect_triangles(positions, soup.triangles, stop);
    if (!connected) return tl::unexpected(connected.error());
    if (connected->faces.empty()) return failure(ErrorCode::Unusable, "no triangle has an area");

    surface.vertices_ = std::move(connected->vertices);
    surface.faces_.reserve(connected->faces.size());
    for (const ConnectedTriangles::Face& face : connected->faces) surface.faces_.push_back({face});
    connected->faces = std::vector<ConnectedTriangles::Face>();  // frees the memory
    surface.measure_faces();
    surface.mark_creases(crease);
    surface.number_components();
    if (!stop.stop_requested()) surface.compute_vertex_normals();
    if (stop.stop_requested()) return failure(ErrorCode::Stopped, "stopped before there was a result");
    surface.tree_ = std::make_unique<Tree>();
    return Made{std::move(surface), std::move(connected->repairs), {}};
}

/// Computes areas and normals. Flat faces get the normals of the faces that face_beside() finds.
void Surface::measure_faces() {
    for (std::size_t f = 0; f < faces_.size(); ++f) {
        const auto face = static_cast<std::uint32_t>(f);
        const Point3 doubled = ConnectedTriangles::doubled_area(positions(face));
        faces_[f].area = length(doubled) / 2;
        faces_[f].normal = unit(doubled);
        total_area_ += faces_[f].area;
    }
    for (std::size_t f = 0; f < faces_.size(); ++f) {
        if (!faces_[f].links.flat) continue;
        const std::uint32_t face = face_beside(static_cast<std::uint32_t>(f));
        if (!faces_[face].links.flat) faces_[f].normal = faces_[face].normal;
        if (faces_[f].normal == Point3{}) faces_[f].normal = {0, 0, 1};
    }
}

/// Walks from a flat face across longest edges. Returns the first face that is not flat, or the last face of the walk
/// if it ends at a border or after kMaxFaces steps.
std::uint32_t Surface::face_beside(std::uint32_t face) const {
    constexpr int kMaxFaces = 100;
    std::uint32_t entry = kNone;
    for (int i = 0; i < kMaxFaces && faces_[face].links.flat; ++i) {
        std::uint32_t longest = entry == 0 ? 1 : 0;
        for (std::uint32_t k = 0; k < 3; ++k) {
            if (k != entry && squared(edge_vector(face, k)) > squared(edge_vector(face, longest))) longest = k;
        }
        const std::uint32_t other = faces_[face].links.twins[longest];
        if (other == kNone) break;
        face = other / 4;
        entry = other % 4;
    }
    return face;
}

void Surface::mark_creases(std::optional<double> crease) {
    constexpr double kMargin = 1e-12;  // of the cosine; rounding bends planes
    const double least = crease ? elementary::cos(std::clamp(*crease, 0.0, std::numbers::pi)) - kMargin : -2;
    for (Face& face : faces_) {
        for (std::uint32_t k = 0; k < 3; ++k) {
            const bool is_border = face.links.twins[k] == kNone;
            const bool is_crease = is_border || dot(face.normal, faces_[face.links.twins[k] / 4].normal) < least;
            border_edges_ += is_border ? 1 : 0;
            face.creases = static_cast<std::uint8_t>(face.creases | is_crease << k);
        }
    }
}

void Surface::number_components() {
    for (Face& face : faces_) face.component = kNone;
    std::vector<std::uint32_t> found;
    for (std::size_t f = 0; f < faces_.size(); ++f) {
        if (faces_[f].component != kNone) continue;
        const auto number = static_cast<std::uint32_t>(components_++);
        faces_[f].component = number;
        found.assign(1, static_cast<std::uint32_t>(f));
        for (std::size_t i = 0; i < found.size(); ++i) {
            for (std::uint32_t k = 0; k < 3; ++k) {
                const std::uint32_t edge = 4 * found[i] + k;
                if (is_crease(edge) || faces_[twin(edge) / 4].component != kNone) continue;
                faces_[twin(edge) / 4].component = number;
                found.push_back(twin(edge) / 4);
            }
        }
    }
}

void Surface::compute_vertex_normals() {
    normals_.assign(vertices_.size(), {});
    for (std::size_t f = 0; f < faces_.size(); ++f) {
        const auto face = static_cast<std::uint32_t>(f);
        for (std::uint32_t k = 0; k < 3; ++k) {
            const double angle = elementary::atan2(2 * faces_[f].area,
                                                   -dot(edge_vector(face, k), edge_vector(face, Links::previous(k))));
            Point3& normal = normals_[faces_[f].links.corners[k]];
            normal = normal + angle * faces_[f].normal;
        }
    }
    // The normals around a vertex may cancel out.
    for (const Face& face : faces_) {
        for (const std::uint32_t v : face.links.corners) {
            if (squared(normals_[v]) < 1e-24) normals_[v] = face.normal;
        }
    }
    for (Point3& normal : normals_) normal = unit(normal);
}

std::array<double, 3> Surface::original_weights(const SurfacePoint& point) const {
    const auto& [a, b, c] = point.weights;
    if (faces_[point.face].links.turned) return {a, c, b};
    return {a, b, c};
}

Point3 Surface::position(const SurfacePoint& point) const {
    const auto [a, b, c] = positions(point.face);
    return point.weights[0] * a + point.weights[1] * b + point.weights[2] * c;
}

Point3 Surface::smooth_normal(const SurfacePoint& point) const {
    const auto& [a, b, c] = faces_[point.face].links.corners;
    const Point3 sum = point.weights[0] * normals_[a] + point.weights[1] * normals_[b] + point.weights[2] * normals_[c];
    return squared(sum) < 1e-24 ? faces_[point.face].normal : 1 / length(sum) * sum;
}

Point3 Surface::to_input(Point3 p) const {
    return origin_ + scale_ * p;
}

Point3 Surface::from_input(Point3 p) const {
    const Point3 moved = p - origin_;
    return {moved.x / scale_, moved.y / scale_, moved.z / scale_};
}

SurfacePoint Surface::trace(const SurfacePoint& from, Point3 move) const {
    return follow(from, move, kMaxSteps).first.end;
}

std::optional<Surface::Line> Surface::trace_within(const SurfacePoint& from, Point3 move, int most) const {
    const auto [line, is_whole] = follow(from, move, most);
    if (!is_whole) return std::nullopt;
    return line;
}

/// Follows a line over at most `most` edges. Returns it, and whether it was followed to its end, border or crease.
std::pair<Surface::Line, bool> Surface::follow(const SurfacePoint& from, Point3 move, int most) const {
    if (const auto to = moved_in_face(from, move)) return {{*to}, true};
    const double size = largest(move);
    if (!(size > 0) || !is_finite(move)) return {{from}, true};
    const Point3 direction = 1 / size * move;
    Walk walk{.face = from.face, .left = size * length(direction), .entry = from.weights};
    if (!begin_walk(walk, direction)) return {{from}, true};
    double least_cosine = 1;
    for (int step = 0; walk.left > walk.distance; ++step) {
        const bool ends = is_crease(4 * walk.face + walk.exit);
        if (ends || step == most) return {{{walk.face, inset(walk.exit_weights(), kInset)}, least_cosine}, ends};
        walk.left -= walk.distance;
        const Point3 before = faces_[walk.face].normal;
        cross_edge(walk);
        least_cosine = std::min(least_cosine, dot(before, faces_[walk.face].normal));
    }
    return {{{walk.face, mixed(walk.entry, walk.exit_weights(), walk.left / walk.distance)}, least_cosine}, true};
}

/// Follows a line that ends in its first face, as most short ones do. Returns none if the line leaves the face, or if
/// rounding errors could be large.
std::optional<SurfacePoint> Surface::moved_in_face(const SurfacePoint& from, Point3 move) const {
    constexpr double kMinShare = 1e-6;  // of the squared move that is in the plane of the face
    const Face& face = faces_[from.face];
    const double all = dot(move, move);
    if (face.links.flat || !(all > 0)) return std::nullopt;
    const Point3 inside = move - dot(move, face.normal) * face.normal;
    const double share = dot(inside, inside) / all;
    if (!(share > kMinShare)) return std::nullopt;
    const Point3 turned = 1 / (2 * face.area * std::sqrt(share)) * cross(inside, face.normal);
    SurfacePoint to = from;
    const auto [a, b, c] = positions(from.face);
    to.weights[0] += dot(turned, c - b);
    to.weights[1] += dot(turned, a - c);
    to.weights[2] += dot(turned, b - a);
    if (!(std::ranges::min(to.weights) >= 0)) return std::nullopt;
    return to;
}

/// Finds where a line leaves its first face. Returns false if the direction is perpendicular to the face.
bool Surface::begin_walk(Walk& walk, Point3 direction) const {
    // On an edge, rounding could make all corners lie on one side of the line.
    constexpr double kMinWeight = 1e-12;
    const auto& [a, b, c] = walk.entry;
    if (std::min({a, b, c}) < kMinWeight) walk.entry = inset(walk.entry, kMinWeight);

    const Point3 u = edge_vector(walk.face, 0);
    const double base = length(u);
    const Point3 x_axis = 1 / base * u;
    walk.x = dot(direction, x_axis);
    walk.y = dot(direction, cross(faces_[walk.face].normal, x_axis));
    const double in_plane = std::sqrt(walk.x * walk.x + walk.y * walk.y);
    if (!(in_plane > Walk::kMinComponent)) return false;
    walk.x /= in_plane;
    walk.y /= in_plane;

    const std::array<double, 3> x{0, base, -dot(edge_vector(walk.face, 2), x_axis)}, y{0, 0, height(walk.face, base)};
    std::array<double, 3> ahead, aside;  // of the corners, relative to the line; the left side is positive
    for (std::size_t i = 0; i < 3; ++i) {
        const double from_x = x[i] - (b * x[1] + c * x[2]), from_y = y[i] - c * y[2];
        ahead[i] = walk.x * from_x + walk.y * from_y;
        aside[i] = walk.x * from_y - walk.y * from_x;
    }
    // The line leaves over the edge that runs from its right to its left side. Rounding may make all corners lie on one
    // side. Then the line leaves at the corner that is farthest ahead.
    const auto is_left = [&aside](std::uint32_t corner) { return aside[corner] > 0; };
    if (is_left(0) == is_left(1) && is_left(1) == is_left(2)) {
        walk.exit = static_cast<std::uint32_t>(std::max_element(ahead.begin(), ahead.end()) - ahead.begin());
    } else {
        while (is_left(walk.exit) || !is_left(Links::next(walk.exit))) walk.exit = Links::next(walk.exit);
        walk.t = aside[walk.exit] / (aside[walk.exit] - aside[Links::next(walk.exit)]);
    }
    const std::uint32_t head = Links::next(walk.exit);
    walk.distance = std::max(0.0, (1 - walk.t) * ahead[walk.exit] + walk.t * ahead[head]);
    walk.edge_x = x[walk.exit] - x[head];
    walk.edge_y = y[walk.exit] - y[head];
    return true;
}

/// Continues a line in the face beyond its exit, whose first corner is on the left.
void Surface::cross_edge(Walk& walk) const {
    constexpr double kMinLength = 0x1p-37;  // shorter than every edge
    const double base = std::max(kMinLength, std::sqrt(walk.edge_x * walk.edge_x + walk.edge_y * walk.edge_y));
    const double x = (walk.x * walk.edge_x + walk.y * walk.edge_y) / base;
    const double y = std::max(Walk::kMinComponent, (walk.y * walk.edge_x - walk.x * walk.edge_y) / base);
    const std::uint32_t edge = twin(4 * walk.face + walk.exit), side = edge % 4;
    walk.face = edge / 4;
    walk.x = x;
    walk.y = y;
    walk.entry = {};
    walk.entry[side] = walk.t;
    walk.entry[Links::next(side)] = 1 - walk.t;

    const double start = (1 - walk.t) * base;
    const Point3 axis = 1 / base * edge_vector(walk.face, side);
    const double rise = height(walk.face, base);
    const double top = x * rise - y * (-dot(edge_vector(walk.face, Links::previous(side)), axis) - start);
    if (top > 0) {  // the third corner is on the left
        const double right = y * (base - start);
        walk.exit = Links::next(side);
        walk.t = right / (top + right);
        walk.edge_x = -dot(edge_vector(walk.face, walk.exit), axis);
        walk.edge_y = -rise;
        walk.distance = x * (base - start - walk.t * walk.edge_x) - y * walk.t * walk.edge_y;
    } else {
        const double left = y * start;
        walk.exit = Links::previous(side);
        walk.t = left > top ? top / (top - left) : 0;
        walk.edge_x = -dot(edge_vector(walk.face, walk.exit), axis);
        walk.edge_y = rise;
        walk.distance = x * ((1 - walk.t) * walk.edge_x - start) + y * (1 - walk.t) * walk.edge_y;
    }
    walk.distance = std::max(0.0, walk.distance);
}

const FaceTree& Surface::tree() const {
    std::call_once(tree_->once, [this] {
        std::vector<FaceTree::Face> faces;
        faces.reserve(face_count());
        for (std::uint32_t f = 0; f < face_count(); ++f) faces.push_back({corners(f), f, faces_[f].links.flat});
        tree_->faces.emplace(vertices_, std::move(faces));  // the surface may move, but its vertices stay in place
    });
    return *tree_->faces;
}

SurfacePoint Surface::nearest(Point3 p) const {
    // From far away, the direction determines the nearest point.
    constexpr double kFar = 1e6, kFarthest = 1e300;
    for (double* value : {&p.x, &p.y, &p.z}) *value = std::clamp(*value, -kFarthest, kFarthest);
    if (const double size = largest(p); size > kFar) p = kFar / size * p;

    return nearest_within(p, Extent::kInfinity).value();
}

std::optional<SurfacePoint> Surface::nearest_within(Point3 p, double distance) const {
    const auto found = tree().nearest(p, distance);
    if (!found) return std::nullopt;
    return SurfacePoint{found->face, found->weights};
}

}  // namespace ccdt
