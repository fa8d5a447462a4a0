// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/surface/surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <numeric>
#include <string>
#include <utility>

#include "core/surface/face_tree.h"
#include "core/surface/surface_repair.h"

namespace ccdt {

namespace {

// Squares and products of lengths, and their sums, must be finite and keep full precision.
constexpr double kMinExtent = 1e-140, kMaxExtent = 1e140;
// Smallest extent relative to the magnitude of the coordinates; a smaller surface has too few distinct coordinates.
constexpr double kMinSize = 1e-9;
// Share of the centroid in points that are moved slightly into their face.
constexpr double kInset = 1e-9;

constexpr std::uint32_t next(std::uint32_t side) {
    return side == 2 ? 0 : side + 1;
}
constexpr std::uint32_t previous(std::uint32_t side) {
    return side == 0 ? 2 : side - 1;
}

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
    return failure(ErrorCode::Unusable, "the extent is too large, or too small for the coordinates");
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

/// State of trace() in one face.
struct Surface::Walk {
    /// A position on an edge, and the way to it.
    struct Exit {
        std::uint32_t side = 0;  ///< edge 0, 1 or 2
        double t = 0;            ///< position on the edge, from its first (0) to its second (1) corner
        double distance = 0;     ///< from the entry
    };

    std::uint32_t face = 0;
    double left = 0;                ///< distance left to go
    std::array<double, 3> entry{};  ///< weights of the position where the line enters the face

    std::array<double, 3> weights_of(const Exit& exit) const {
        std::array<double, 3> weights{};
        weights[exit.side] = 1 - exit.t;
        weights[next(exit.side)] = exit.t;
        return weights;
    }
    /// Ends in the face, on the way to the exit.
    SurfacePoint end(const Exit& exit) const {
        return {face, mixed(entry, weights_of(exit), std::min(1.0, left / exit.distance))};
    }
    SurfacePoint stop_at(const Exit& exit) const { return {face, inset(weights_of(exit), kInset)}; }
};

struct Surface::Tree {
    std::once_flag once;
    std::optional<FaceTree> faces;  ///< made when it is needed first
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

    // Multiples of 2^-52 have exact differences, whose products do not underflow.
    const auto rounded = [](double value) { return (value + 1) - 1; };
    std::vector<Point3> positions(soup.vertices.size());
    for (std::size_t v = 0; v < positions.size(); ++v) {
        const Point3 p = surface.from_input(soup.vertices[v]);
        if (is_finite(p)) positions[v] = {rounded(p.x), rounded(p.y), rounded(p.z)};
    }
    auto connected = connect_triangles(positions, soup.triangles, stop);
    if (!connected) return tl::unexpected(connected.error());
    if (connected->faces.empty()) return failure(ErrorCode::Unusable, "no triangle has an area");

    surface.vertices_ = std::move(connected->vertices);
    surface.faces_.resize(connected->faces.size());
    std::vector<std::uint8_t> flat(surface.faces_.size());
    for (std::size_t f = 0; f < flat.size(); ++f) {
        const ConnectedTriangles::Face& from = connected->faces[f];
        Face& face = surface.faces_[f];
        face.corners = from.corners;
        face.twins = from.twins;
        face.triangle = from.triangle;
        face.turned = from.turned;
        flat[f] = from.flat;
    }
    connected->faces = {};
    surface.measure_faces(flat);
    surface.mark_creases(crease);
    surface.number_components();
    surface.compute_vertex_normals();
    if (stop.stop_requested()) return failure(ErrorCode::Stopped, "stopped before there was a result");
    surface.tree_ = std::make_unique<Tree>();
    return Made{std::move(surface), std::move(connected->repairs), {}};
}

/// Computes areas and normals. The normals of flat faces come from their neighbours at the longest edge.
/// @param flat  [faces]
void Surface::measure_faces(const std::vector<std::uint8_t>& flat) {
    for (std::size_t f = 0; f < faces_.size(); ++f) {
        const auto face = static_cast<std::uint32_t>(f);
        const Point3 doubled = cross(edge_vector(face, 0), edge_vector(face, 1));
        faces_[f].area = length(doubled) / 2;
        faces_[f].normal = unit(doubled);
        total_area_ += faces_[f].area;
    }
    const auto across = [this](std::uint32_t face) {
        std::uint32_t longest = 0;
        for (std::uint32_t k = 1; k < 3; ++k) {
            const Point3 a = edge_vector(face, k), b = edge_vector(face, longest);
            if (dot(a, a) > dot(b, b)) longest = k;
        }
        return faces_[face].twins[longest];
    };
    constexpr int kMaxFlat = 100;  // successive flat faces
    for (std::size_t f = 0; f < faces_.size(); ++f) {
        if (!flat[f]) continue;
        std::uint32_t edge = 4 * static_cast<std::uint32_t>(f);
        for (int i = 0; i < kMaxFlat && edge != kNone && flat[edge / 4]; ++i) edge = across(edge / 4);
        if (edge != kNone && !flat[edge / 4]) faces_[f].normal = faces_[edge / 4].normal;
        if (dot(faces_[f].normal, faces_[f].normal) == 0) faces_[f].normal = {0, 0, 1};
    }
}

void Surface::mark_creases(std::optional<double> crease) {
    const double least = crease ? std::cos(std::clamp(*crease, 0.0, std::acos(-1.0))) : -2;
    for (Face& face : faces_) {
        for (std::uint32_t k = 0; k < 3; ++k) {
            const bool is_crease = face.twins[k] == kNone || dot(face.normal, faces_[face.twins[k] / 4].normal) < least;
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
            const double angle =
                std::atan2(2 * faces_[f].area, -dot(edge_vector(face, k), edge_vector(face, previous(k))));
            Point3& normal = normals_[faces_[f].corners[k]];
            normal = normal + angle * faces_[f].normal;
        }
    }
    // The normals around a vertex may cancel out.
    for (const Face& face : faces_) {
        for (const std::uint32_t v : face.corners) {
            if (dot(normals_[v], normals_[v]) < 1e-24) normals_[v] = face.normal;
        }
    }
    for (Point3& normal : normals_) normal = unit(normal);
}

std::array<double, 3> Surface::original_weights(const SurfacePoint& point) const {
    const auto& [a, b, c] = point.weights;
    if (faces_[point.face].turned) return {a, c, b};
    return {a, b, c};
}

Point3 Surface::place(const SurfacePoint& point) const {
    const auto [a, b, c] = places(point.face);
    return point.weights[0] * a + point.weights[1] * b + point.weights[2] * c;
}

Point3 Surface::smooth_normal(const SurfacePoint& point) const {
    const auto& [a, b, c] = faces_[point.face].corners;
    const Point3 sum = point.weights[0] * normals_[a] + point.weights[1] * normals_[b] + point.weights[2] * normals_[c];
    return dot(sum, sum) < 1e-24 ? faces_[point.face].normal : unit(sum);
}

Point3 Surface::to_input(Point3 p) const {
    return origin_ + scale_ * p;
}

Point3 Surface::from_input(Point3 p) const {
    const Point3 moved = p - origin_;
    return {moved.x / scale_, moved.y / scale_, moved.z / scale_};
}

SurfacePoint Surface::trace(const SurfacePoint& from, Point3 move) const {
    const double size = largest(move);
    if (!(size > 0) || !is_finite(move)) return from;
    const Point3 way = 1 / size * move;

    Walk walk{.face = from.face, .left = size * length(way), .entry = from.weights};
    // On an edge, rounding could make all corners lie on one side of the line.
    constexpr double kLeastWeight = 1e-12;
    constexpr double kLeastInPlane = 1e-12;  // share of the move that is not perpendicular to the face
    constexpr double kLeastLength = 1e-17;   // shorter than every edge
    if (std::min({walk.entry[0], walk.entry[1], walk.entry[2]}) < kLeastWeight)
        walk.entry = inset(walk.entry, kLeastWeight);

    // The first face has corner 0 at the origin, and its edge 0 on the x axis.
    const Point3 u = edge_vector(walk.face, 0), v = -1 * edge_vector(walk.face, 2);
    double base = length(u);
    const Point3 x_axis = 1 / base * u;
    const Point3 y_axis = cross(faces_[walk.face].normal, x_axis);
    double x = dot(way, x_axis), y = dot(way, y_axis);
    const double in_plane = std::sqrt(x * x + y * y);
    if (!(in_plane > kLeastInPlane)) return from;
    x /= in_plane;
    y /= in_plane;
    const double px[3] = {0, base, dot(v, x_axis)};
    const double py[3] = {0, 0, 2 * faces_[walk.face].area / base};
    const double start_x = walk.entry[1] * px[1] + walk.entry[2] * px[2], start_y = walk.entry[2] * py[2];
    double ahead[3], aside[3];  // of the corners, relative to the line; the left side is positive
    for (int i = 0; i < 3; ++i) {
        ahead[i] = x * (px[i] - start_x) + y * (py[i] - start_y);
        aside[i] = x * (py[i] - start_y) - y * (px[i] - start_x);
    }
    // Rounding may make all corners lie on one side. Then the line passes through the one that is farthest ahead.
    const bool some_left = aside[0] > 0 || aside[1] > 0 || aside[2] > 0;
    const bool all_left = aside[0] > 0 && aside[1] > 0 && aside[2] > 0;
    if (!some_left || all_left) {
        aside[std::max_element(ahead, ahead + 3) - ahead] = all_left ? 0 : std::numeric_limits<double>::min();
    }
    Walk::Exit exit;
    while (aside[exit.side] > 0 || !(aside[next(exit.side)] > 0)) exit.side = next(exit.side);
    const std::uint32_t head = next(exit.side);
    exit.t = -aside[exit.side] / (aside[head] - aside[exit.side]);
    exit.distance = std::max(0.0, ahead[exit.side] + exit.t * (ahead[head] - ahead[exit.side]));

    // The direction relative to the edge, as the next face sees it: from the second to the first corner.
    double edge_x = px[exit.side] - px[head], edge_y = py[exit.side] - py[head];
    for (int step = 0;; ++step) {
        if (walk.left <= exit.distance) return walk.end(exit);
        const std::uint32_t edge = 4 * walk.face + exit.side;
        if (is_crease(edge) || step == kMaxSteps) return walk.stop_at(exit);
        walk.left -= exit.distance;
        base = std::max(kLeastLength, std::sqrt(edge_x * edge_x + edge_y * edge_y));
        const double along = (x * edge_x + y * edge_y) / base;
        y = std::max(0.0, (y * edge_x - x * edge_y) / base);
        x = along;

        // The face beyond has the edge on the x axis, with its left end at the origin.
        const std::uint32_t side = twin(edge) % 4;
        walk.face = twin(edge) / 4;
        const double t = 1 - exit.t;
        walk.entry = {};
        walk.entry[side] = 1 - t;
        walk.entry[next(side)] = t;
        const Point3 axis = 1 / base * edge_vector(walk.face, side);
        const Point3 from_right = edge_vector(walk.face, next(side));
        const Point3 from_left = -1 * edge_vector(walk.face, previous(side));
        const double height = 2 * faces_[walk.face].area / base;
        const double top = x * height - y * (dot(from_left, axis) - t * base);
        if (top > 0) {
            const double right = y * base * (1 - t);
            exit.side = next(side);
            exit.t = right / (top + right);
            edge_x = -dot(from_right, axis);
            edge_y = -height;
            exit.distance = x * (base * (1 - t) - exit.t * edge_x) - y * exit.t * edge_y;
        } else {
            const double left = y * base * t;
            exit.side = previous(side);
            exit.t = left - top > 0 ? -top / (left - top) : 0;
            edge_x = dot(from_left, axis);
            edge_y = height;
            exit.distance = x * ((1 - exit.t) * edge_x - base * t) + y * (1 - exit.t) * edge_y;
        }
        exit.distance = std::max(0.0, exit.distance);
    }
}

SurfacePoint Surface::nearest(Point3 p) const {
    std::call_once(tree_->once, [this] {
        std::vector<std::uint32_t> all(face_count());
        std::iota(all.begin(), all.end(), 0U);
        // The surface may move, but its vertices and faces stay in place.
        tree_->faces.emplace(std::move(all), [vertices = vertices_.data(), faces = faces_.data()](std::uint32_t f) {
            const auto& [a, b, c] = faces[f].corners;
            return std::array{vertices[a], vertices[b], vertices[c]};
        });
    });
    // From far away, the direction determines the nearest point.
    constexpr double kFar = 1e6, kFarthest = 1e300;
    for (double* value : {&p.x, &p.y, &p.z}) *value = std::clamp(*value, -kFarthest, kFarthest);
    if (const double size = largest(p); size > kFar) p = kFar / size * p;

    const FaceTree::Nearest found = tree_->faces->nearest(p);
    return {found.face, found.weights};
}

}  // namespace ccdt
