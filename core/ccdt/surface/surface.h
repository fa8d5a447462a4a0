// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <utility>
#include <vector>

#include "core/base/result.h"
#include "core/ccdt/surface/face_tree.h"
#include "core/ccdt/surface/surface_note.h"
#include "core/ccdt/surface/surface_repair.h"
#include "core/ccdt/surface/triangle_soup.h"
#include "core/geometry/point3.h"

namespace ccdt {

/// A position on a surface.
struct SurfacePoint {
    std::uint32_t face = 0;
    /// Barycentric coordinates in the face: each >= 0, with sum 1 up to rounding.
    std::array<double, 3> weights{1, 0, 0};

    /// Returns the position of a corner (0, 1 or 2) of a face.
    static SurfacePoint corner(std::uint32_t face, std::size_t corner) {
        SurfacePoint point{face, {0, 0, 0}};
        point.weights[corner] = 1;
        return point;
    }
};

/// A surface made of triangles: every edge belongs to one or two triangles, and the triangles around each vertex form
/// one fan. Neighbouring triangles have the same orientation. A surface may have borders and several components.
/// Coordinates are in the unit frame: translated and scaled such that the longest side of the bounding box is 1, and
/// rounded to multiples of 2^-36. So no edge is shorter than 2^-36, and vertices whose positions differ only by
/// rounding errors of double precision nearly always have the same position.
///
/// Half-edge h is edge h % 4 (0, 1 or 2) of face h / 4, as in Triangulation: it runs from corner h % 4 to the next one.
class Surface {
public:
    static constexpr std::uint32_t kNone = ~std::uint32_t{0};
    static constexpr int kMaxSteps = 1 << 14;  ///< largest number of edges that trace() crosses

    struct Made;  ///< a surface, with the repairs and warnings that users should know

    /// Makes a surface from triangles, repaired by connect_triangles(). Vertices that no triangle uses are ignored.
    /// @param crease  angle between the normals of two faces, in radians, above which their common edge counts as a
    ///                crease; none: no edge does
    /// @param stop    polled regularly
    ///
    /// Errors: Unusable if a coordinate is not finite (the field is "vertices/N"), if no triangle has an area, or if
    /// the longest side of the bounding box is not from 1e-140 to 1e140 or is less than 1e-9 times the largest
    /// coordinate; LimitExceeded if there are more than 2^30 triangles; Stopped. Deterministic. O(n log n).
    static Result<Made> create(const TriangleSoup& soup, std::optional<double> crease,
                               const std::stop_token& stop = {});

    Surface(Surface&&) noexcept;
    Surface& operator=(Surface&&) noexcept;
    ~Surface();

    std::size_t vertex_count() const { return vertices_.size(); }
    std::size_t face_count() const { return faces_.size(); }
    Point3 vertex(std::uint32_t vertex) const { return vertices_[vertex]; }
    std::array<std::uint32_t, 3> corners(std::uint32_t face) const { return faces_[face].links.corners; }
    /// Returns the half-edge on the other side of the edge; kNone on a border.
    std::uint32_t twin(std::uint32_t edge) const { return faces_[edge / 4].links.twins[edge % 4]; }
    /// Whether an edge is on the border or a crease. Points do not cross such edges.
    bool is_crease(std::uint32_t edge) const { return (faces_[edge / 4].creases >> edge % 4 & 1) != 0; }

    /// Loads a face into the cache before it is used.
    void prefetch(std::uint32_t face) const {
        __builtin_prefetch(&faces_[face].links);
        __builtin_prefetch(&faces_[face].normal);
    }
    std::array<Point3, 3> positions(std::uint32_t face) const {
        const auto& [a, b, c] = faces_[face].links.corners;
        return {vertices_[a], vertices_[b], vertices_[c]};
    }
    double area(std::uint32_t face) const { return faces_[face].area; }
    double total_area() const { return total_area_; }
    /// Returns the unit normal of a face. A face without area has the normal of the first face with an area that is
    /// reached across longest edges.
    Point3 normal(std::uint32_t face) const { return faces_[face].normal; }
    /// Returns the mean normal of the faces around a vertex, weighted by their angles; unit length.
    Point3 vertex_normal(std::uint32_t vertex) const { return normals_[vertex]; }
    /// Returns the number of a face's component. Faces are connected by edges that are neither borders nor creases.
    std::uint32_t component(std::uint32_t face) const { return faces_[face].component; }
    std::size_t component_count() const { return components_; }
    /// Returns the number of edges on borders; 0 if the surface is closed.
    std::size_t border_edges() const { return border_edges_; }

    /// Returns the triangle of the soup from which a face was made.
    std::uint32_t triangle_of(std::uint32_t face) const { return faces_[face].links.triangle; }
    /// Whether a face is a triangle of the soup that was turned over.
    bool is_turned(std::uint32_t face) const { return faces_[face].links.turned; }
    /// Returns the barycentric coordinates of a point with respect to the corners of triangle_of(point.face), in the
    /// order of the soup. Faces that were turned over have their corners in another order.
    std::array<double, 3> original_weights(const SurfacePoint& point) const;

    Point3 position(const SurfacePoint& point) const;
    /// Returns the normal interpolated between the normals of the corners; unit length.
    Point3 smooth_normal(const SurfacePoint& point) const;

    /// Converts between the unit frame and the coordinates of the soup.
    Point3 to_input(Point3 p) const;
    Point3 from_input(Point3 p) const;
    /// Returns the length in the coordinates of the soup that corresponds to 1 in the unit frame.
    double scale() const { return scale_; }

    /// Follows a straight line on the surface, over edges as if the faces were unfolded into a plane. The line ends
    /// after the length of `move`. At a border or crease, or after kMaxSteps edges, it ends earlier, slightly inside
    /// the last face.
    /// @param move  vector in space. The line begins in the direction of its projection to the face, and has the length
    ///              of the whole vector. If the vector is zero, not finite or perpendicular to the face, `from` is
    ///              returned
    ///
    /// O(faces crossed), at most kMaxSteps.
    SurfacePoint trace(const SurfacePoint& from, Point3 move) const;
    /// A line on the surface: the point that trace() returns, and the least cosine between the normals of two
    /// successive faces; 1 if the line crosses no edge.
    struct Line {
        SurfacePoint end;
        double least_cosine = 1;
    };
    /// Returns the line that trace() follows if it crosses at most `most` edges; otherwise none.
    std::optional<Line> trace_within(const SurfacePoint& from, Point3 move, int most) const;

    /// Returns the point of the surface that is nearest to p, in the unit frame. Faces without area do not count.
    /// @param p  may be infinite, but not NaN
    ///
    /// Several threads may call it at once. O(log faces), typically.
    SurfacePoint nearest(Point3 p) const;
    /// Returns the same point for a finite p if its distance is less than `distance`; otherwise none. Faster.
    std::optional<SurfacePoint> nearest_within(Point3 p, double distance) const;

    /// Returns the search tree of all faces. The first call builds it, in O(faces log faces).
    const FaceTree& tree() const;

private:
    struct Tree;
    struct Walk;
    struct Face {
        ConnectedTriangles::Face links;
        std::uint8_t creases = 0;  ///< bit i is set if edge i is a crease
        std::uint32_t component = 0;
        double area = 0;
        Point3 normal{};
    };

    Surface();

    Point3 edge_vector(std::uint32_t face, std::uint32_t side) const {
        const auto& corners = faces_[face].links.corners;
        return vertices_[corners[side == 2 ? 0 : side + 1]] - vertices_[corners[side]];
    }
    /// Returns the height of a face over a side with a given length; 0 for flat faces, because rounding errors in their
    /// height would move points along them.
    double height(std::uint32_t face, double base) const {
        return faces_[face].links.flat ? 0 : 2 * faces_[face].area / base;
    }
    std::optional<SurfacePoint> moved_in_face(const SurfacePoint& from, Point3 move) const;
    std::pair<Line, bool> follow(const SurfacePoint& from, Point3 move, int most) const;
    bool begin_walk(Walk& walk, Point3 direction) const;
    void cross_edge(Walk& walk) const;
    void measure_faces();
    std::uint32_t face_beside(std::uint32_t face) const;
    void mark_creases(std::optional<double> crease);
    void number_components();
    void compute_vertex_normals();

    std::vector<Point3> vertices_;
    std::vector<Point3> normals_;
    std::vector<Face> faces_;
    std::size_t components_ = 0;
    std::size_t border_edges_ = 0;
    double total_area_ = 0;
    Point3 origin_;
    double scale_ = 1;
    std::unique_ptr<Tree> tree_;
};

struct Surface::Made {
    Surface surface;
    std::vector<SurfaceNote> repairs;
    std::vector<SurfaceNote> warnings;
};

}  // namespace ccdt
