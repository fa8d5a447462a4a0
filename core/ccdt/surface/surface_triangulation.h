// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/base/executor.h"
#include "core/ccdt/surface/crease_vertices.h"
#include "core/ccdt/surface/surface.h"
#include "core/ccdt/surface/unfolding.h"
#include "core/geometry/point3.h"
#include "core/mesh/site_blocks.h"
#include "core/mesh/triangle_links.h"

namespace ccdt {

/// A triangulation of sites on a surface. Its vertices lie on the surface, and its edges are straight in space.
/// Vertices [0, sites) are sites, of which the last ones may be fixed. Further vertices lie on borders and creases, or
/// are vertices of the surface whose removal would change the topology or fold the triangulation.
class SurfaceTriangulation {
public:
    static constexpr std::uint32_t kNone = TriangleLinks::kNone;

    /// Triangulates the sites: inserts them into the faces, makes the triangulation Delaunay, and removes the vertices
    /// of the surface, unless a removal would change the topology or fold the triangulation.
    /// @param surface  must outlive this object
    /// @param sites    numbered along a space-filling curve; followed by fixed sites
    /// @param fixed    number of fixed sites
    /// @param spacing  returns the wanted distance of sites at a point
    /// @param creases  vertices along borders and creases
    /// @param stop     polled regularly; after a stop the object must not be used
    /// O(n log n) for n = sites + faces.
    SurfaceTriangulation(const Surface& surface, std::vector<SurfacePoint> sites, std::size_t fixed,
                         const std::function<double(const SurfacePoint&)>& spacing, const CreaseVertices& creases,
                         Executor& executor, const std::stop_token& stop = {});
    /// Triangulates the vertices along borders and creases, without sites. The parameters are as above.
    /// O(n log n) for n = vertices + faces.
    SurfaceTriangulation(const Surface& surface, const CreaseVertices& creases, Executor& executor,
                         const std::stop_token& stop = {});

    const Surface& surface() const { return *surface_; }
    Executor& executor() const { return *executor_; }
    const SiteBlocks& blocks() const { return blocks_; }

    std::size_t site_count() const { return sites_; }
    std::size_t free_count() const { return blocks_.sites(); }
    std::size_t vertex_count() const { return positions_.size(); }
    std::size_t triangle_count() const { return links_.triangle_count(); }
    bool is_site(std::uint32_t vertex) const { return vertex < sites_; }
    /// Whether the surface has sharp edges.
    bool has_sharp_edges() const { return !reaches_.empty(); }
    bool is_free(std::uint32_t vertex) const { return vertex < blocks_.sites(); }

    static std::uint32_t edge(std::uint32_t triangle, std::uint32_t number) { return 4 * triangle + number; }
    static std::uint32_t triangle_of(std::uint32_t edge) { return edge / 4; }
    static std::uint32_t next(std::uint32_t edge) { return TriangleLinks::next(edge); }
    static std::uint32_t previous(std::uint32_t edge) { return TriangleLinks::previous(edge); }
    const std::array<std::uint32_t, 3>& corners(std::uint32_t triangle) const { return links_.corners(triangle); }
    std::uint32_t origin(std::uint32_t edge) const { return links_.origin(edge); }
    std::uint32_t target(std::uint32_t edge) const { return links_.target(edge); }
    /// Returns the half-edge on the other side of the edge; kNone on borders and creases.
    std::uint32_t twin(std::uint32_t edge) const { return links_.is_constrained(edge) ? kNone : links_.twin(edge); }
    std::uint32_t edge_of(std::uint32_t vertex) const { return links_.edge_of(vertex); }
    bool are_joined(std::uint32_t a, std::uint32_t b) const { return links_.are_joined(a, b); }
    template <class Function>
    void for_edges(std::uint32_t vertex, Function&& function) const {
        links_.for_edges(vertex, function);
    }

    Point3 point(std::uint32_t vertex) const { return positions_[vertex]; }
    /// Returns the normal of the face on which a vertex lies.
    Point3 face_normal(std::uint32_t vertex) const { return face_normals_[vertex]; }
    /// Returns the vector from one vertex to another; the unfolded vector if there is a sharp edge between two sites.
    /// Other vertices lie on borders and creases, so straight lines to them stay on the surface.
    Point3 toward(std::uint32_t from, std::uint32_t to) const {
        const Point3 straight = positions_[to] - positions_[from];
        if (!is_sharp_between(from, to)) return straight;
        return unfolded_toward(points_[from], straight, to).value_or(straight);
    }
    /// Whether there is a sharp edge between two sites.
    bool is_sharp_between(std::uint32_t a, std::uint32_t b) const {
        return !reaches_.empty() && is_site(a) && is_site(b) && reaches_[a] > 0 &&
               is_sharp(face_normals_[a], face_normals_[b]);
    }
    /// Returns the vector from a point to a site beyond a sharp edge, unfolded into the plane of the point. Returns
    /// none if the surface does not follow it, if there is a bend instead of a sharp edge, or if the vector is much
    /// longer than the spacing of sites.
    std::optional<Point3> unfolded_toward(const SurfacePoint& from, Point3 straight, std::uint32_t to) const {
        const auto flat = unfolded(*surface_, from, straight, points_[to].face, reaches_[to]);
        if (!flat || !flat->crosses_sharp_edge) return std::nullopt;
        return flat->vector;
    }
    const SurfacePoint& on_surface(std::uint32_t vertex) const { return points_[vertex]; }

    std::array<Point3, 3> positions(std::uint32_t triangle) const {
        const auto& [a, b, c] = corners(triangle);
        return {positions_[a], positions_[b], positions_[c]};
    }
    Point3 along(std::uint32_t edge) const { return positions_[target(edge)] - positions_[origin(edge)]; }
    /// Returns the vector perpendicular to the edge, of the same length, that points into the edge's triangle in its
    /// plane; 0 if the triangle has no area.
    Point3 inward(std::uint32_t edge) const {
        const Point3 normal = doubled_normal(edge / 4);
        const double area = length(normal);
        return area > 0 ? 1 / area * cross(normal, along(edge)) : Point3{};
    }
    /// Returns the normal of a triangle, with the length of its doubled area.
    Point3 doubled_normal(std::uint32_t triangle) const {
        const auto [a, b, c] = positions(triangle);
        return cross(b - a, c - a);
    }
    /// Returns the doubled area of the unfolded triangle.
    double doubled_area(std::uint32_t triangle) const {
        const auto& [a, b, c] = corners(triangle);
        return length(cross(toward(a, b), toward(a, c)));
    }

    /// Flips edges until all are Delaunay: the angles opposite to each edge, measured in space, add up to at most 180
    /// degrees. Beside sharp edges, flips make edges shorter on the surface instead. Does not flip creases, nor edges
    /// whose flip would fold the triangulation or join two vertices twice. Makes at most ten flips per triangle.
    /// @returns  the number of flips
    std::size_t restore_delaunay(const std::stop_token& stop = {});

    /// Moves a vertex along the surface. Halves the move, up to three times, until all triangles around the vertex keep
    /// their orientation and a part of their area. If that does not suffice, the vertex does not move. Calls for
    /// vertices without common neighbours may run in parallel.
    void move(std::uint32_t vertex, Point3 by);

    /// Removes a site from the triangulation and inserts it again in the middle of the first of several triangles that
    /// is suitable.
    /// @returns  false, without any change, if the site's neighbours do not allow its removal, or if no triangle is
    ///           suitable
    bool relocate(std::uint32_t site, std::span<const std::uint32_t> triangles);

private:
    /// Whether a point is on a component with sharp edges.
    bool is_on_sharp(const SurfacePoint& point) const {
        return !sharp_.empty() && sharp_[surface_->component(point.face)] != 0;
    }
    std::optional<SurfacePoint> middle(std::uint32_t triangle) const;
    void copy_faces();
    std::uint32_t split(const CreaseVertices::OnEdge& at, std::uint32_t edge);
    std::vector<std::uint32_t> split_creases(const CreaseVertices& creases);
    void bisect_creases(const CreaseVertices& creases, const std::stop_token& stop);
    void simplify(const CreaseVertices& creases, const std::stop_token& stop);
    void insert_sites(std::vector<std::uint32_t> face_of, const std::stop_token& stop);
    void remove_corners(const CreaseVertices& creases, const std::stop_token& stop);
    bool remove(std::uint32_t vertex, double agreement = 0);
    bool can_collapse(std::uint32_t edge, double agreement) const;
    std::size_t legalise(std::size_t most, const std::stop_token& stop = {});
    void locate(const SurfacePoint& point);
    double squared_length(std::uint32_t a, std::uint32_t b) const;
    bool wants_flip(std::uint32_t edge) const;
    bool allows_flip(std::uint32_t edge) const;
    void renumber();

    const Surface* surface_;
    Executor* executor_;
    std::size_t sites_;
    SiteBlocks blocks_;  ///< blocks of the free sites
    TriangleLinks links_;
    std::vector<SurfacePoint> points_;  ///< [vertices]
    std::vector<Point3> positions_;     ///< [vertices]
    std::vector<Point3> normals_;       ///< [vertices] smooth normals of the surface
    std::vector<Point3> face_normals_;  ///< [vertices] normals of the faces under the vertices
    std::vector<std::uint8_t> sharp_;   ///< [components] whether a component has sharp edges; empty without sites
    /// [sites] longest unfolded vectors; 0 on components without sharp edges; empty if no edge of the surface is sharp
    std::vector<double> reaches_;
    std::vector<std::uint8_t> moved_;   ///< [vertices] whether triangles at it may be new since restore_delaunay()
    std::vector<std::uint32_t> stack_;  ///< edges that may not be Delaunay
};

}  // namespace ccdt
