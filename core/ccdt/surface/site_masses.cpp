// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/surface/site_masses.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "core/ccdt/surface/face_pieces.h"

namespace ccdt {

namespace {
constexpr std::uint32_t kNone = SurfaceTriangulation::kNone;
constexpr std::size_t kPieces = 4096;  ///< pieces per task

/// Returns the barycentric coordinates of a point of a sequence that covers a triangle evenly. The centres of long thin
/// triangles would not cover a surface that consists of them.
std::array<double, 3> spread_point(std::size_t number) {
    const auto i = static_cast<double>(number);
    const double u = kFirstStep * i, v = kSecondStep * i;
    return position_in_triangle(u - std::floor(u), v - std::floor(v));
}
}  // namespace

/// A triangle in a face.
struct SiteMasses::Part {
    std::uint32_t face;
    std::array<std::array<double, 3>, 3> corners;  ///< barycentric coordinates
    double area;
    double mass;       ///< upper bound, in sites
    double cells = 0;  ///< number of pieces of the density in it if their densities differ much; else 0

    SurfacePoint at(const std::array<double, 3>& weights) const {
        SurfacePoint point{face, {0, 0, 0}};
        for (std::size_t k = 0; k < 3; ++k) {
            for (std::size_t i = 0; i < 3; ++i) point.weights[i] += weights[k] * corners[k][i];
        }
        return point;
    }
};

SiteMasses::SiteMasses(const Surface& surface, const SurfaceDensity& density, double capacity) {
    for (std::uint32_t f = 0; f < surface.face_count(); ++f) {
        const double mass = density.mass(surface, f) / capacity;
        if (!(mass > 0)) continue;
        // In a face with a picture, the pieces are small enough for the highest density. If the density is high in a
        // small part of the face only, pieces of this size in the whole face would be too many.
        constexpr double kUneven = 8;
        const double area = surface.area(f), side = density.side(f);
        const double most = side > 1 ? density.largest(f) * area / capacity : mass;
        const double cells = most > kUneven * mass ? side * side : 0;
        divide(surface, density, capacity, {f, {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}, area, most, cells});
    }
}

/// Appends the pieces of a part. They are similar to the part. If they would be much longer than the spacing, or if the
/// density is uneven, the part is first divided across its longest edge. A long part of little mass is not divided; its
/// piece may lie anywhere in it.
void SiteMasses::divide(const Surface& surface, const SurfaceDensity& density, double capacity, const Part& part) {
    constexpr double kPiecesPerSite = 3;
    constexpr std::uint32_t kMaxSide = 8192;  // pieces along the side of a part
    constexpr double kLongest = 1.3;          // edge of a piece, in spacings
    constexpr double kMinMass = 1.0 / 8;      // of a part that is divided
    constexpr std::uint32_t kCoarse = 4;      // pieces along the side of a part of uneven density
    if (!(part.mass > 0)) return;
    const auto side =
        static_cast<std::uint32_t>(std::clamp(std::ceil(std::sqrt(part.mass * kPiecesPerSite)), 1.0, double{kMaxSide}));
    std::array<double, 3> squares{};  // squared edges from each corner to the next one
    for (std::size_t k = 0; k < 3; ++k) {
        const Point3 edge =
            surface.position({part.face, part.corners[(k + 1) % 3]}) - surface.position({part.face, part.corners[k]});
        squares[k] = dot(edge, edge);
    }
    const auto longest = static_cast<std::size_t>(std::ranges::max_element(squares) - squares.begin());
    const double limit = kLongest * side;
    // Where the number of pieces is limited, a part is not divided further.
    const bool is_long = side < kMaxSide && squares[longest] * part.mass > limit * limit * part.area;
    const bool is_uneven = part.cells > 1 && side > kCoarse;
    if (is_uneven || (is_long && part.mass > kMinMass)) {
        const std::size_t a = longest, b = (longest + 1) % 3;
        std::array<double, 3> middle{};
        for (std::size_t i = 0; i < 3; ++i) middle[i] = (part.corners[a][i] + part.corners[b][i]) / 2;
        for (const std::size_t moved : {b, a}) {
            Part half = part;
            half.corners[moved] = middle;
            half.area /= 2;
            half.cells /= 2;
            half.mass =
                part.cells > 1 ? density.largest(part.face, half.corners) * half.area / capacity : part.mass / 2;
            divide(surface, density, capacity, half);
        }
        return;
    }
    const double area = part.area / capacity / (static_cast<double>(side) * side);
    const auto add = [&](const std::array<double, 3>& weights) {
        const SurfacePoint at = part.at(weights);
        const double piece = area * density.at(at);
        if (piece > 0) pieces_.push_back({at, piece, kNone});
    };
    if (is_long) return add(spread_point(pieces_.size()));
    // Every other row is reversed, so that successive pieces are close to each other.
    std::size_t row = 0, begin = pieces_.size();
    const auto reverse = [&] {
        if (row % 2 == 1) std::reverse(pieces_.begin() + static_cast<std::ptrdiff_t>(begin), pieces_.end());
    };
    for_face_pieces(side, [&](const std::array<double, 3>& weights) {
        if (const auto own = static_cast<std::size_t>(weights[2] * side); own != row) {
            reverse();
            row = own;
            begin = pieces_.size();
        }
        add(weights);
    });
    reverse();
}

/// Returns a triangle for each face at which a search can begin: a triangle at the innermost site on the nearest face
/// that has sites. Distances between faces are counted in edges that are not creases.
std::vector<std::uint32_t> SiteMasses::first_triangles(const SurfaceTriangulation& mesh) {
    const Surface& surface = mesh.surface();
    std::vector<std::uint32_t> near(surface.face_count(), kNone), reached;
    std::vector<double> most(surface.face_count(), 0);
    for (std::uint32_t v = 0; v < mesh.site_count(); ++v) {
        const auto& [face, weights] = mesh.on_surface(v);
        const double inside = std::ranges::min(weights);
        if (near[face] == kNone) {
            reached.push_back(face);
        } else if (inside <= most[face]) {
            continue;
        }
        most[face] = inside;
        near[face] = SurfaceTriangulation::triangle_of(mesh.edge_of(v));
    }
    for (std::size_t i = 0; i < reached.size(); ++i) {
        for (std::uint32_t k = 0; k < 3; ++k) {
            const std::uint32_t h = 4 * reached[i] + k, twin = surface.twin(h);
            if (surface.is_crease(h) || near[twin / 4] != kNone) continue;
            near[twin / 4] = near[reached[i]];
            reached.push_back(twin / 4);
        }
    }
    return near;
}

/// Returns the triangle at which the search for a piece begins: the previous triangle of the piece, or the triangle of
/// a close piece. If both are far away, as in long faces, returns a triangle at the nearest of some sites on the face
/// (Muecke, Saias and Zhu 1999, "Fast randomized point location without preprocessing").
/// O(1); O(sqrt(sites)) if both are far away.
std::uint32_t SiteMasses::start_of(const SurfaceTriangulation& mesh, const Piece& piece, std::uint32_t close) {
    constexpr double kFar = 32;  // edges
    const Point3 position = mesh.surface().position(piece.at);
    const auto is_on_face = [&](std::uint32_t v) {
        return mesh.is_site(v) && mesh.on_surface(v).face == piece.at.face;
    };
    const auto squared_distance = [&](std::uint32_t v) {
        return dot(mesh.point(v) - position, mesh.point(v) - position);
    };
    std::uint32_t start = close;
    double least = squared_distance(mesh.corners(close)[0]);
    const auto try_at = [&](std::uint32_t v, std::uint32_t triangle) {
        if (!is_on_face(v) || squared_distance(v) >= least) return;
        least = squared_distance(v);
        start = triangle;
    };
    // The triangle may have moved to another position with a relocated site.
    if (piece.triangle < mesh.triangle_count()) {
        for (const std::uint32_t v : mesh.corners(piece.triangle)) try_at(v, piece.triangle);
    }
    const Point3 edge = mesh.along(SurfaceTriangulation::edge(start, 0));
    if (least < kFar * kFar * dot(edge, edge)) return start;
    const auto stride = static_cast<std::uint32_t>(std::ceil(std::sqrt(static_cast<double>(mesh.site_count()))));
    for (std::uint32_t v = 0; v < mesh.site_count(); v += stride)
        try_at(v, SurfaceTriangulation::triangle_of(mesh.edge_of(v)));
    return start;
}

SiteMasses::View SiteMasses::view(const SurfaceTriangulation& mesh, const SurfacePoint& at, Point3 position,
                                  std::uint32_t triangle) {
    const Point3 face_normal = mesh.surface().normal(at.face);
    View view;
    const auto& corners = mesh.corners(triangle);
    std::array<Point3, 3> positions;
    int beyond = 0;  // corners beyond a sharp edge
    for (std::size_t k = 0; k < 3; ++k) {
        positions[k] = mesh.point(corners[k]) - position;
        view.squared_distance = std::min(view.squared_distance, dot(positions[k], positions[k]));
        if (!mesh.has_sharp_edges() || !mesh.is_site(corners[k])) continue;
        if (!is_sharp(face_normal, mesh.face_normal(corners[k]))) continue;
        const auto flat = mesh.unfolded_toward(at, positions[k], corners[k]);
        if (!flat) continue;
        positions[k] = *flat;
        ++beyond;
    }
    const auto& [a, b, c] = positions;
    const Point3 own_normal = cross(b - a, c - a), normal = beyond > 0 ? face_normal : own_normal;
    view.shares = {dot(cross(b, c), normal), dot(cross(c, a), normal), dot(cross(a, b), normal)};
    const double scale = std::abs(view.shares[0]) + std::abs(view.shares[1]) + std::abs(view.shares[2]);
    for (double& share : view.shares) share = scale > 0 ? share / scale : 1.0 / 3;
    view.is_lost = beyond == 3 || view.least() < 0 || (beyond == 0 && !(dot(own_normal, face_normal) > 0));
    return view;
}

/// Walks to the triangle above a piece. Where the triangles do not follow the surface, a walk may not end. Then the
/// piece is in the visited triangle from which it is least outside.
SiteMasses::View SiteMasses::locate(const SurfaceTriangulation& mesh, Piece& piece) {
    constexpr int kMaxSteps = 8;  // that come no nearer; a vertex has about six triangles
    const Point3 position = mesh.surface().position(piece.at);
    View best;
    double nearest = std::numeric_limits<double>::infinity();
    std::uint32_t next = piece.triangle;
    for (int steps = 0; next != kNone && steps < kMaxSteps && best.least() < 0; ++steps) {
        const View now = view(mesh, piece.at, position, next);
        if (now.least() > best.least()) {
            best = now;
            piece.triangle = next;
        }
        if (now.squared_distance < nearest) {
            nearest = now.squared_distance;
            steps = 0;
        }
        const auto out = static_cast<std::uint32_t>(std::ranges::min_element(now.shares) - now.shares.begin());
        next = mesh.twin(SurfaceTriangulation::edge(next, (out + 1) % 3));
        if (next != kNone) next /= 4;
    }
    return best;
}

std::vector<double> SiteMasses::measure(const SurfaceTriangulation& mesh) {
    if (!is_located_) first_ = first_triangles(mesh);
    std::vector<std::array<double, 3>> shares(pieces_.size());
    for_ranges(mesh.executor(), pieces_.size(), kPieces, [&](std::size_t begin, std::size_t end) {
        std::uint32_t start = kNone;  // the triangle above an earlier piece of the same face
        std::uint32_t lost = 0;       // pieces since then that were not found
        for (std::size_t i = begin; i < end; ++i) {
            Piece& piece = pieces_[i];
            const bool is_first = i == begin || piece.at.face != pieces_[i - 1].at.face;
            if (is_first) {
                start = first_[piece.at.face];
                lost = 0;
            }
            if (start == kNone) continue;
            if (!is_located_) piece.triangle = start_of(mesh, piece, is_first ? start : pieces_[i - 1].triangle);
            View found = locate(mesh, piece);
            // On a thin tube, nearly all pieces are lost. So searches are repeated less and less often.
            const bool is_repeated = found.is_lost && std::has_single_bit(++lost);
            for (const std::uint32_t other : {start, first_[piece.at.face]}) {
                if (!is_repeated || !found.is_lost) break;
                Piece again{piece.at};
                again.triangle = start_of(mesh, again, other);
                const View now = locate(mesh, again);
                if (now.is_lost && now.least() <= found.least()) continue;
                found = now;
                piece.triangle = again.triangle;
            }
            if (!found.is_lost) {
                start = piece.triangle;
                lost = 0;
            }
            shares[i] = found.shares;
            double sum = 0;
            for (double& share : shares[i]) sum += share = std::max(share, 0.0);
            for (double& share : shares[i]) share = sum > 0 ? share / sum : 1.0 / 3;
        }
    });
    is_located_ = true;
    std::vector<double> masses(mesh.vertex_count(), 0);
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
        if (pieces_[i].triangle == kNone) continue;
        // Corners on borders and creases pass their shares on to the sites of the same triangle, which are on the same
        // side of the crease.
        const auto& corners = mesh.corners(pieces_[i].triangle);
        double sites = 0, of_others = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            if (mesh.is_site(corners[k]))
                ++sites;
            else
                of_others += shares[i][k];
        }
        for (std::size_t k = 0; k < 3; ++k) {
            if (sites > 0 && !mesh.is_site(corners[k])) continue;
            masses[corners[k]] += (shares[i][k] + (sites > 0 ? of_others / sites : 0)) * pieces_[i].mass;
        }
    }
    return masses;
}

}  // namespace ccdt
