// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/surface/surface_triangulation.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "core/geometry/point.h"
#include "core/geometry/predicates.h"
#include "core/mesh/insertion_steps.h"

namespace ccdt {

namespace {

using Links = TriangleLinks;
constexpr std::uint32_t kNone = Links::kNone;

constexpr std::size_t kMaxFlipsAround = 200;  ///< flips after a vertex was removed or inserted

/// Inserts sites into the triangulations of single faces, in coordinates of the face's plane.
class FaceInsertion {
public:
    /// @param face_of  [triangles] face of the surface
    /// @param flat     [vertices] coordinates in the plane of the current face
    FaceInsertion(TriangleLinks& links, std::vector<std::uint32_t> face_of, std::vector<Point>& flat)
        : links_(links), flat_(flat), face_of_(std::move(face_of)) {}

    /// Begins the insertion into a face. Calls flatten(vertex) for the vertices of its triangles, to get their
    /// coordinates.
    template <class Flatten>
    void begin(std::uint32_t face, Flatten&& flatten) {
        // The triangle with the number of the face lies in the face, and the other triangles of the face are connected
        // to it.
        stack_.assign(1, face);
        seen_.resize(face_of_.size(), 0);
        for (std::size_t i = 0; i < stack_.size(); ++i) {
            seen_[stack_[i]] = 1;
            for (std::uint32_t k = 0; k < 3; ++k) {
                const std::uint32_t h = Links::edge(stack_[i], k), twin = links_.twin(h);
                flat_[links_.origin(h)] = flatten(links_.origin(h));
                if (twin == kNone || face_of_[twin / 4] != face || seen_[twin / 4] != 0) continue;
                seen_[twin / 4] = 1;
                stack_.push_back(twin / 4);
            }
        }
    }

    /// Inserts a site near the triangle `start` of its face. Returns a triangle at the site.
    std::uint32_t insert(std::uint32_t site, std::uint32_t start) {
        constexpr std::size_t kMaxFlips = 100'000;
        const std::uint32_t triangle = find(flat_[site], start), face = face_of_[triangle];
        flat_[site] = inside(flat_[site], triangle);
        links_.divide(site, triangle);
        face_of_.resize(links_.triangle_count(), face);
        stack_.clear();
        links_.for_edges(site, [&](std::uint32_t h) { stack_.push_back(Links::next(h)); });
        for (std::size_t flips = 0; !stack_.empty() && flips < kMaxFlips;) {
            const std::uint32_t h = stack_.back(), twin = links_.twin(h);
            stack_.pop_back();
            if (twin == kNone || face_of_[twin / 4] != face || !wants_flip(h)) continue;
            links_.flip(h);
            ++flips;
            stack_.insert(stack_.end(), {h, Links::previous(h), twin, Links::previous(twin)});
        }
        return Links::triangle_of(links_.edge_of(site));
    }

private:
    Point at(std::uint32_t edge) const { return flat_[links_.origin(edge)]; }

    bool wants_flip(std::uint32_t h) const {
        const Point a = at(h), b = at(Links::next(h)), c = at(Links::previous(h));
        return in_circle(a, b, c, at(Links::previous(links_.twin(h))));
    }

    /// Walks to the triangle of the same face that contains a point. If rounding places the point outside the face,
    /// returns the last triangle of the walk.
    std::uint32_t find(Point p, std::uint32_t triangle) const {
        const std::uint32_t face = face_of_[triangle];
        std::uint32_t from = kNone;
        std::size_t steps = 0;
        for (bool moved = true; moved && steps < face_of_.size(); ++steps) {
            moved = false;
            for (std::uint32_t i = 0; i < 3 && !moved; ++i) {
                const std::uint32_t h = Links::edge(triangle, i), twin = links_.twin(h);
                if (twin == kNone || twin / 4 == from || face_of_[twin / 4] != face) continue;
                if (orientation(at(h), at(Links::next(h)), p) >= 0) continue;
                from = triangle;
                triangle = twin / 4;
                moved = true;
            }
        }
        return triangle;
    }

    /// Returns p, moved towards the middle of a triangle as little as necessary to lie strictly inside the triangle.
    /// Otherwise the parts of the triangle could be flat or turned over, and flips would not end.
    Point inside(Point p, std::uint32_t triangle) const {
        constexpr double kFirstShare = 0x1p-40;
        const Point a = at(Links::edge(triangle, 0)), b = at(Links::edge(triangle, 1)),
                    c = at(Links::edge(triangle, 2));
        const Point middle = 1.0 / 3 * (a + b + c);
        Point moved = p;
        for (double share = kFirstShare; share <= 1; share *= 2) {
            if (orientation(a, b, moved) > 0 && orientation(b, c, moved) > 0 && orientation(c, a, moved) > 0) break;
            moved = p + share * (middle - p);
        }
        return moved;
    }

    TriangleLinks& links_;
    std::vector<Point>& flat_;
    std::vector<std::uint32_t> face_of_;  ///< [triangles] face of the surface
    std::vector<std::uint32_t> stack_;
    std::vector<std::uint8_t> seen_;  ///< [triangles] whether begin() has visited the triangle
};

/// Coordinates in the plane of a triangle, with the first corner as the origin.
class FacePlane {
public:
    explicit FacePlane(const std::array<Point3, 3>& corners) : origin_(corners[0]) {
        const Point3 along = corners[1] - corners[0], normal = cross(along, corners[2] - corners[0]);
        const Point3 across = cross(normal, along);
        if (dot(along, along) > 0) x_ = 1 / length(along) * along;
        if (dot(across, across) > 0) y_ = 1 / length(across) * across;
    }
    Point operator()(Point3 p) const { return {dot(p - origin_, x_), dot(p - origin_, y_)}; }

private:
    Point3 origin_, x_, y_;
};

}  // namespace

SurfaceTriangulation::SurfaceTriangulation(const Surface& surface, std::vector<SurfacePoint> sites, std::size_t fixed,
                                           const std::function<double(const SurfacePoint&)>& spacing,
                                           const CreaseVertices& creases, Executor& executor,
                                           const std::stop_token& stop)
    : surface_(&surface),
      executor_(&executor),
      sites_(sites.size()),
      blocks_(sites.size() - fixed),
      points_(std::move(sites)) {
    // Length of the longest lines that are unfolded, in spacings. Around the end of a needle, longer lines are not the
    // shortest ones between two sites.
    constexpr double kReach = 3;
    sharp_ = sharp_components(surface);
    if (std::ranges::count(sharp_, 1) > 0) {
        for (const SurfacePoint& site : points_) reaches_.push_back(is_on_sharp(site) ? kReach * spacing(site) : 0);
    }
    copy_faces();
    insert_sites(split_creases(creases), stop);
    if (!stop.stop_requested()) simplify(creases, stop);
}

SurfaceTriangulation::SurfaceTriangulation(const Surface& surface, const CreaseVertices& creases, Executor& executor,
                                           const std::stop_token& stop)
    : surface_(&surface), executor_(&executor), sites_(0), blocks_(0) {
    copy_faces();
    bisect_creases(creases, stop);
    if (!stop.stop_requested()) simplify(creases, stop);
}

/// Makes the triangulation Delaunay and removes the vertices of the surface that are not needed.
void SurfaceTriangulation::simplify(const CreaseVertices& creases, const std::stop_token& stop) {
    restore_delaunay(stop);
    remove_corners(creases, stop);
    if (stop.stop_requested()) return;
    renumber();
    restore_delaunay(stop);
}

/// Makes every face a triangle. The vertices of the surface follow after the sites.
void SurfaceTriangulation::copy_faces() {
    const Surface& surface = *surface_;
    const auto first = static_cast<std::uint32_t>(sites_);
    points_.resize(sites_ + surface.vertex_count());
    links_.add_vertices(points_.size());
    for (std::uint32_t f = 0; f < surface.face_count(); ++f) {
        const auto [a, b, c] = surface.corners(f);
        links_.add({first + a, first + b, first + c});
    }
    for (std::uint32_t f = 0; f < surface.face_count(); ++f) {
        for (std::uint32_t i = 0; i < 3; ++i) {
            const std::uint32_t h = Links::edge(f, i);
            links_.join(h, surface.twin(h));
            links_.set_constrained(h, surface.is_crease(h));
            points_[links_.origin(h)] = SurfacePoint::corner(f, i);
        }
    }
    for (std::uint32_t f = 0; f < surface.face_count(); ++f) {
        for (std::uint32_t i = 0; i < 3; ++i) links_.keep_edge(Links::edge(f, i));
    }
    for (const SurfacePoint& point : points_) locate(point);
}

/// Appends the position of a point and the normals of the surface there.
void SurfaceTriangulation::locate(const SurfacePoint& point) {
    positions_.push_back(surface_->position(point));
    normals_.push_back(surface_->smooth_normal(point));
    face_normals_.push_back(surface_->normal(point.face));
    moved_.push_back(1);
}

/// Appends an added vertex and splits an edge there.
/// @returns  TriangleLinks::split()
std::uint32_t SurfaceTriangulation::split(const CreaseVertices::OnEdge& at, std::uint32_t edge) {
    const auto vertex = static_cast<std::uint32_t>(points_.size());
    SurfacePoint point{at.edge / 4, {0, 0, 0}};
    point.weights[at.edge % 4] = 1 - at.share;
    point.weights[(at.edge % 4 + 1) % 3] = at.share;
    points_.push_back(point);
    locate(point);
    links_.add_vertices(1);
    return links_.split(vertex, edge);
}

/// Splits the edges of borders and creases at the added vertices: each edge in the middle of its vertices, then each
/// half, with flips in between. If all vertices of a long edge were joined to the opposite corner, the number of flips
/// would be quadratic.
void SurfaceTriangulation::bisect_creases(const CreaseVertices& creases, const std::stop_token& stop) {
    struct Part {
        std::uint32_t from, to;  // its ends
        std::size_t begin, end;  // added vertices between them
    };
    const auto& added = creases.added;
    std::vector<Part> parts, halves;
    for (std::size_t begin = 0, end = 0; begin < added.size(); begin = end) {
        const std::uint32_t edge = added[begin].edge;
        while (end < added.size() && added[end].edge == edge) ++end;
        parts.push_back({links_.origin(edge), links_.target(edge), begin, end});
    }
    for (; !parts.empty() && !stop.stop_requested(); parts.swap(halves)) {
        halves.clear();
        for (const auto& [from, to, begin, end] : parts) {
            const std::size_t middle = begin + (end - begin) / 2;
            const auto vertex = static_cast<std::uint32_t>(points_.size());
            std::uint32_t edge = kNone;
            // On a border, only one of the ends may have a half-edge to the other one.
            links_.for_edges(from, [&, to = to](std::uint32_t h) {
                if (links_.target(h) == to) edge = h;
                if (links_.apex(h) == to && edge == kNone) edge = Links::previous(h);
            });
            split(added[middle], edge);
            if (begin < middle) halves.push_back({from, vertex, begin, middle});
            if (middle + 1 < end) halves.push_back({vertex, to, middle + 1, end});
        }
        restore_delaunay(stop);
    }
}

/// Splits the edges of borders and creases at the added vertices.
/// @returns  [triangles] face of each triangle
std::vector<std::uint32_t> SurfaceTriangulation::split_creases(const CreaseVertices& creases) {
    std::vector<std::uint32_t> face_of(links_.triangle_count());
    std::iota(face_of.begin(), face_of.end(), 0U);
    // The last vertex on an edge comes first, so that the edge itself remains the part before the vertex. The edges of
    // a face are split in the order 2, 1, 0. The first split of edge 2 gives edge 0 another number.
    std::uint32_t renumbered = kNone, number = kNone;
    for (auto each = creases.added.rbegin(); each != creases.added.rend(); ++each) {
        const std::uint32_t edge = each->edge == renumbered ? number : each->edge, twin = links_.twin(edge);
        const std::uint32_t after = split(*each, edge);
        if (each->edge % 4 == 2 && renumbered != Links::next(each->edge)) {
            renumbered = Links::next(each->edge);
            number = after;
        }
        face_of.push_back(face_of[edge / 4]);
        if (twin != kNone) face_of.push_back(face_of[twin / 4]);
    }
    return face_of;
}

void SurfaceTriangulation::insert_sites(std::vector<std::uint32_t> face_of, const std::stop_token& stop) {
    std::vector<std::uint32_t> order(sites_);
    std::iota(order.begin(), order.end(), 0U);
    std::ranges::stable_sort(order, {}, [&](std::uint32_t site) { return points_[site].face; });
    std::vector<Point> flat(points_.size());
    FaceInsertion insertion(links_, std::move(face_of), flat);
    for (std::size_t begin = 0, end = 0; begin < order.size() && !stop.stop_requested(); begin = end) {
        const std::uint32_t face = points_[order[begin]].face;
        const FacePlane plane(surface_->positions(face));
        insertion.begin(face, [&](std::uint32_t vertex) { return plane(positions_[vertex]); });
        for (end = begin; end < order.size() && points_[order[end]].face == face; ++end)
            flat[order[end]] = plane(positions_[order[end]]);
        std::uint32_t last = face;
        for_insertion_steps(end - begin, [&](std::span<const std::uint32_t> step) {
            for (const std::uint32_t i : step) last = insertion.insert(order[begin + i], last);
            return !stop.stop_requested();
        });
    }
}

std::size_t SurfaceTriangulation::restore_delaunay(const std::stop_token& stop) {
    constexpr std::size_t kMaxPerEdge = 10;
    constexpr std::size_t kTriangles = 1024;  // per task
    const auto is_moved = [&](std::uint32_t v) { return moved_[v] != 0; };
    std::vector<std::vector<std::uint32_t>> found(links_.triangle_count() / kTriangles + 1);
    for_ranges(*executor_, links_.triangle_count(), kTriangles, [&](std::size_t begin, std::size_t end) {
        for (auto t = static_cast<std::uint32_t>(begin); t < end; ++t) {
            for (std::uint32_t i = 0; i < 3 && !links_.is_removed(t); ++i) {
                const std::uint32_t h = Links::edge(t, i), twin = links_.twin(h);
                if (twin == kNone || twin < h) continue;
                if (std::ranges::none_of(corners(t), is_moved) && !is_moved(links_.apex(twin))) continue;
                if (wants_flip(h)) found[begin / kTriangles].push_back(h);
            }
        }
    });
    for (const auto& edges : found) stack_.insert(stack_.end(), edges.begin(), edges.end());
    const std::size_t most = kMaxPerEdge * links_.triangle_count(), flips = legalise(most, stop);
    if (flips < most && !stop.stop_requested()) std::ranges::fill(moved_, std::uint8_t{0});
    return flips;
}

/// Flips the edges on the stack, and edges around them, until all are Delaunay or the limit on flips is reached.
std::size_t SurfaceTriangulation::legalise(std::size_t most, const std::stop_token& stop) {
    constexpr std::size_t kStopStride = 4096;  // flips between polls of the stop token
    std::size_t flips = 0;
    while (!stack_.empty() && flips < most && (flips % kStopStride != 0 || !stop.stop_requested())) {
        const std::uint32_t h = stack_.back(), twin = links_.twin(h);
        stack_.pop_back();
        if (links_.is_removed(h / 4) || twin == kNone || links_.is_constrained(h)) continue;
        if (!wants_flip(h) || !allows_flip(h)) continue;
        links_.flip(h);
        ++flips;
        stack_.insert(stack_.end(), {h, Links::previous(h), twin, Links::previous(twin)});
    }
    // If the limit was reached, the next restore_delaunay() must check the edges that are left on the stack.
    for (const std::uint32_t h : stack_) {
        if (links_.is_removed(h / 4)) continue;
        for (const std::uint32_t v : corners(h / 4)) moved_[v] = 1;
    }
    stack_.clear();
    return flips;
}

/// Returns the squared length of an edge on the surface. If the unfolded edge is unknown, returns the squared length of
/// the straight edge.
double SurfaceTriangulation::squared_length(std::uint32_t a, std::uint32_t b) const {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    const auto [from, to] = std::minmax(a, b);
    const Point3 straight = positions_[to] - positions_[from];
    if (!is_sharp_between(from, to)) return dot(straight, straight);
    const auto flat = unfolded(*surface_, points_[from], straight, points_[to].face, kInfinity);
    const Point3 vector = flat ? flat->vector : straight;
    return dot(vector, vector);
}

/// Whether the angles opposite to an edge add up to more than 180 degrees. Beside sharp edges, angles in space mean
/// nothing, and angles of unfolded triangles contradict each other. There, returns whether the flip makes the edge
/// shorter on the surface, so that flips end.
bool SurfaceTriangulation::wants_flip(std::uint32_t edge) const {
    constexpr double kTolerance = 1e-9;  // of the sine of the sum; prevents endless flips of four points on a circle
    const std::uint32_t a = links_.origin(edge), b = links_.target(edge);
    const std::uint32_t c = links_.apex(edge), d = links_.apex(links_.twin(edge));
    if (!reaches_.empty()) {
        const std::array<std::pair<std::uint32_t, std::uint32_t>, 6> pairs{
            {{a, b}, {c, d}, {a, c}, {b, d}, {b, c}, {a, d}}};
        if (std::ranges::any_of(pairs, [&](const auto& pair) { return is_sharp_between(pair.first, pair.second); }))
            return squared_length(c, d) < (1 - kTolerance) * squared_length(a, b);
    }
    const Point3 ca = positions_[a] - positions_[c], cb = positions_[b] - positions_[c];
    const Point3 da = positions_[a] - positions_[d], db = positions_[b] - positions_[d];
    const double cos_c = dot(ca, cb), cos_d = dot(da, db);
    if (cos_c >= 0 && cos_d >= 0) return false;
    const double sin_c = length(cross(ca, cb)), sin_d = length(cross(da, db));
    const double scale = std::sqrt((sin_c * sin_c + cos_c * cos_c) * (sin_d * sin_d + cos_d * cos_d));
    return cos_c * sin_d + cos_d * sin_c < -kTolerance * scale;
}

/// Whether the flip of an edge keeps the orientation of both triangles, and creates no second edge between two
/// vertices.
bool SurfaceTriangulation::allows_flip(std::uint32_t edge) const {
    const std::uint32_t twin = links_.twin(edge);
    const std::uint32_t third = links_.apex(edge), fourth = links_.apex(twin);
    if (third == fourth) return false;
    const std::uint32_t a = links_.origin(edge), b = links_.target(edge);
    // Returns whether the three neighbours of an end of the edge keep their order, seen from this end.
    const auto is_convex = [&](std::uint32_t end, std::uint32_t left, std::uint32_t middle, std::uint32_t right) {
        const Point3 x = toward(end, left), y = toward(end, middle), z = toward(end, right);
        return dot(cross(x, z), cross(x, y) + cross(y, z)) > 0;
    };
    if (!is_convex(a, fourth, b, third) || !is_convex(b, third, a, fourth)) return false;
    return !links_.are_joined(third, fourth);
}

/// Removes the vertices of the surface by collapsing edges, with flips in between.
void SurfaceTriangulation::remove_corners(const CreaseVertices& creases, const std::stop_token& stop) {
    // Least agreement of new triangles with the surface in each round, see can_collapse(). Triangles that deviate more
    // are made only if no other removals are left, since they could cut through thin tubes: test
    // DistributeOnSurface.FollowsThinTubesOfSmallFaces. Across sharp edges, all triangles deviate.
    constexpr std::array kAgreements{0.9, 0.6, 0.0, 0.0};
    std::vector<std::uint32_t> left;
    for (std::uint32_t v = 0; v < surface_->vertex_count(); ++v) {
        if (creases.corner[v] == 0) left.push_back(v);
    }
    // Every second vertex along the space-filling curve, then every second one of the others, and so on. So triangles
    // become larger everywhere at the same time. Beside much smaller ones, large triangles cut through thin tubes.
    std::ranges::stable_sort(left, {}, [](std::uint32_t v) { return std::countr_zero(v); });
    for (std::uint32_t& v : left) v += static_cast<std::uint32_t>(sites_);
    for (const double each : kAgreements) {
        std::erase_if(left, [&](std::uint32_t v) {
            return stop.stop_requested() || remove(v, is_on_sharp(points_[v]) ? 0 : each);
        });
    }
}

/// Removes a vertex by collapsing one of its edges. A vertex on a border or crease is merged with an adjacent one along
/// it.
/// @returns  false, without any change, if no edge can be collapsed
bool SurfaceTriangulation::remove(std::uint32_t vertex, double agreement) {
    constexpr std::size_t kMaxCandidates = 32;  // a vertex may have very many neighbours
    if (links_.edge_of(vertex) == kNone) return true;
    std::vector<std::pair<double, std::uint32_t>> edges;
    std::vector<std::uint32_t> around;
    bool on_crease = false;
    links_.for_edges(vertex, [&](std::uint32_t h) {
        edges.emplace_back(dot(along(h), along(h)), h);
        around.push_back(h);
        on_crease = on_crease || links_.is_constrained(h);
    });
    if (on_crease) std::erase_if(edges, [&](const auto& each) { return !links_.is_constrained(each.second); });
    const auto last = edges.begin() + static_cast<std::ptrdiff_t>(std::min(edges.size(), kMaxCandidates));
    std::ranges::partial_sort(edges, last);
    const auto found =
        std::find_if(edges.begin(), last, [&](const auto& each) { return can_collapse(each.second, agreement); });
    if (found == last) return false;
    links_.collapse(found->second);
    for (const std::uint32_t h : around) {
        if (links_.is_removed(h / 4)) continue;
        stack_.insert(stack_.end(), {h, Links::next(h), Links::previous(h)});
        for (const std::uint32_t corner : corners(h / 4)) moved_[corner] = 1;
    }
    legalise(kMaxFlipsAround);
    return true;
}

/// Whether merging the origin of an edge with its target keeps the topology, and turns no triangle away from the sum of
/// the surface's normals at its corners.
/// @param agreement  cosine that the angle between the triangle's normal and this sum must exceed
bool SurfaceTriangulation::can_collapse(std::uint32_t edge, double agreement) const {
    const std::uint32_t a = links_.origin(edge), b = links_.target(edge), twin = links_.twin(edge);
    std::size_t common = 0;
    bool sound = true;
    links_.for_edges(a, [&](std::uint32_t h) {
        const std::uint32_t x = links_.target(h), y = links_.apex(h);
        if (x != b && links_.are_joined(b, x)) ++common;
        // On a border, the last neighbour has no half-edge from a.
        if (y != b && links_.twin(Links::previous(h)) == kNone && links_.are_joined(b, y)) ++common;
        if (x == b || y == b) return;
        const Point3 normal = cross(positions_[x] - positions_[b], positions_[y] - positions_[b]);
        const Point3 up = normals_[b] + normals_[x] + normals_[y];
        sound = sound && dot(normal, up) > agreement * length(normal) * length(up);
    });
    if (!sound || common != (twin == kNone ? 1 : 2)) return false;
    const auto is_free = [&](std::uint32_t h) {
        // Otherwise the triangle is the only one between its border or crease and the opposite corner.
        if (links_.is_constrained(Links::next(h)) || links_.is_constrained(Links::previous(h))) return false;
        // The opposite corner loses a neighbour. It must keep three, unless it is on a border.
        const std::uint32_t first = links_.edge_of(links_.apex(h));
        std::uint32_t fourth = first;
        for (int i = 0; i < 3 && fourth != kNone; ++i) fourth = links_.twin(Links::previous(fourth));
        return fourth != first;
    };
    return is_free(edge) && (twin == kNone || is_free(twin));
}

/// Numbers the remaining vertices and triangles successively.
void SurfaceTriangulation::renumber() {
    std::vector<std::uint32_t> number_of(points_.size(), kNone);
    std::uint32_t count = 0;
    for (std::uint32_t v = 0; v < points_.size(); ++v) {
        if (!is_site(v) && links_.edge_of(v) == kNone) continue;
        points_[count] = points_[v];
        positions_[count] = positions_[v];
        normals_[count] = normals_[v];
        face_normals_[count] = face_normals_[v];
        number_of[v] = count++;
    }
    points_.resize(count);
    positions_.resize(count);
    normals_.resize(count);
    face_normals_.resize(count);
    moved_.assign(count, 1);
    links_.renumber(number_of, count);
}

void SurfaceTriangulation::move(std::uint32_t vertex, Point3 by) {
    constexpr int kAttempts = 4;
    constexpr double kMinArea = 0.05;  // share of a triangle's area that a move must leave
    const Point3 before = positions_[vertex];
    if (by == Point3{} || links_.edge_of(vertex) == kNone) return;
    for (int attempt = 0; attempt < kAttempts; ++attempt, by = 0.5 * by) {
        const SurfacePoint to = surface_->trace(points_[vertex], by);
        const Point3 position = surface_->position(to), up = surface_->smooth_normal(to);
        bool sound = true;
        std::uint32_t a = links_.target(links_.edge_of(vertex));
        Point3 old_side = positions_[a] - before, new_side = positions_[a] - position;
        links_.for_edges(vertex, [&](std::uint32_t h) {
            const std::uint32_t first = std::exchange(a, links_.apex(h));
            const Point3 x = std::exchange(old_side, positions_[a] - before);
            const Point3 u = std::exchange(new_side, positions_[a] - position);
            const Point3 old = cross(x, old_side), now = cross(u, new_side);
            sound = sound && dot(now, old) >= kMinArea * dot(old, old);
            if (!sound || dot(now, up) > 0) return;
            const Point3 others = normals_[first] + normals_[a];
            sound = dot(now, up + others) >= std::min(0.0, dot(old, normals_[vertex] + others));
        });
        if (!sound) continue;
        points_[vertex] = to;
        positions_[vertex] = position;
        normals_[vertex] = up;
        face_normals_[vertex] = surface_->normal(to.face);
        moved_[vertex] = 1;
        return;
    }
}

/// Returns the point of the surface at the middle of a triangle. Returns none if the triangles around the point would
/// be folded, or if the triangle does not follow the surface, as at a fold.
std::optional<SurfacePoint> SurfaceTriangulation::middle(std::uint32_t triangle) const {
    constexpr double kMaxTilt = 0.9;     // least cosine of the angle between the triangle and the surface
    constexpr double kMaxOffset = 0.15;  // distance from the surface, relative to the root of the doubled area
    const auto [a, b, c] = positions(triangle);
    const Point3 along = 1.0 / 3 * (b - a + c - a), normal = doubled_normal(triangle);
    const SurfacePoint point = surface_->trace(points_[corners(triangle)[0]], along);
    const Point3 p = surface_->position(point), off = p - a - along;
    const double area = length(normal), least = area * area / 10;  // each part has at least a tenth of the area
    const bool fits = dot(cross(a - p, b - p), normal) > least && dot(cross(b - p, c - p), normal) > least &&
                      dot(cross(c - p, a - p), normal) > least;
    if (!fits || dot(off, off) > kMaxOffset * kMaxOffset * area) return std::nullopt;
    if (dot(surface_->normal(point.face), normal) < kMaxTilt * area) return std::nullopt;
    return point;
}

bool SurfaceTriangulation::relocate(std::uint32_t site, std::span<const std::uint32_t> triangles) {
    const auto fits = [&](std::uint32_t triangle) {
        if (links_.is_removed(triangle)) return false;
        const auto& around = corners(triangle);
        return std::ranges::find(around, site) == around.end() && middle(triangle).has_value();
    };
    const auto found = std::ranges::find_if(triangles, fits);
    if (found == triangles.end()) return false;
    // Flips after the removal may change the triangle, but they do not move its vertices.
    const SurfacePoint point = *middle(*found);
    const auto around = corners(*found);
    if (!remove(site)) return false;
    std::uint32_t triangle = *found;
    if (links_.is_removed(triangle) || corners(triangle) != around) triangle = triangle_of(links_.edge_of(around[0]));
    points_[site] = point;
    positions_[site] = surface_->position(point);
    normals_[site] = surface_->smooth_normal(point);
    face_normals_[site] = surface_->normal(point.face);
    moved_[site] = 1;
    links_.divide(site, triangle);
    for_edges(site, [&](std::uint32_t h) { stack_.push_back(Links::next(h)); });
    legalise(kMaxFlipsAround);
    return true;
}

}  // namespace ccdt
