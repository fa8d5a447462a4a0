// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/surface/site_masses.h"

#include <algorithm>
#include <cmath>

#include "core/surface/face_pieces.h"

namespace ccdt {

namespace {
constexpr std::uint32_t kNone = SurfaceTriangulation::kNone;
constexpr std::size_t kPieces = 4096;  ///< pieces per task
}  // namespace

SiteMasses::SiteMasses(const Surface& surface, const SurfaceDensity& density, double capacity) {
    constexpr double kPiecesPerSite = 3;
    constexpr double kMaxSide = 8192;  // pieces along the side of a face
    for (std::uint32_t f = 0; f < surface.face_count(); ++f) {
        const double mass = density.mass(surface, f) / capacity;
        if (!(mass > 0)) continue;
        // In a face that follows a picture, the pieces are small enough where the density is highest.
        const double most = density.side(f) > 1 ? density.largest(f) * surface.area(f) / capacity : mass;
        const auto side =
            static_cast<std::uint32_t>(std::clamp(std::ceil(std::sqrt(most * kPiecesPerSite)), 1.0, kMaxSide));
        const double area = surface.area(f) / capacity / (static_cast<double>(side) * side);
        // Every other row is reversed, so that successive pieces are close to each other.
        std::size_t row = 0, begin = pieces_.size();
        const auto reverse = [&] {
            if (row % 2 == 1) std::reverse(pieces_.begin() + static_cast<std::ptrdiff_t>(begin), pieces_.end());
        };
        for_face_pieces(side, [&](const std::array<double, 3>& weights) {
            const SurfacePoint at{f, weights};
            if (const auto own = static_cast<std::size_t>(weights[2] * side); own != row) {
                reverse();
                row = own;
                begin = pieces_.size();
            }
            const double piece = area * density.at(at);
            if (piece > 0) pieces_.push_back({surface.place(at), piece, f, kNone});
        });
        reverse();
    }
}

/// Returns a triangle for each face at which a search can begin: a triangle at a site on the nearest face that has
/// sites. Distances between faces are counted in edges that are not creases.
std::vector<std::uint32_t> SiteMasses::first_triangles(const SurfaceTriangulation& mesh) {
    const Surface& surface = mesh.surface();
    std::vector<std::uint32_t> near(surface.face_count(), kNone), reached;
    for (std::uint32_t v = 0; v < mesh.site_count(); ++v) {
        const std::uint32_t face = mesh.on_surface(v).face;
        if (near[face] != kNone) continue;
        near[face] = SurfaceTriangulation::triangle_of(mesh.edge_of(v));
        reached.push_back(face);
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

/// Walks to the triangle above a piece. Returns the shares of its corners. The corners beyond a sharp edge are unfolded
/// into the plane of the piece.
SiteMasses::Located SiteMasses::locate(const SurfaceTriangulation& mesh, Piece& piece) {
    constexpr int kMaxSteps = 256;  // a walk on a bent surface may not end
    const Point3 face_normal = mesh.surface().normal(piece.face);
    std::array<double, 3> shares{};
    int beyond = 0;        // corners beyond a sharp edge
    bool is_lost = false;  // the walk may have lost its way across a sharp edge
    std::uint32_t from = kNone;
    for (int step = 0;; ++step) {
        const auto& corners = mesh.corners(piece.triangle);
        std::array<Point3, 3> places;
        beyond = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const Point3 normal = mesh.face_normal(corners[k]);
            places[k] = mesh.point(corners[k]) - piece.place;
            if (!mesh.is_site(corners[k]) || !is_sharp(face_normal, normal)) continue;
            places[k] = unfolded(places[k], face_normal, normal);
            ++beyond;
        }
        const auto& [a, b, c] = places;
        const Point3 normal = beyond > 0 ? face_normal : cross(b - a, c - a);
        shares = {dot(cross(b, c), normal), dot(cross(c, a), normal), dot(cross(a, b), normal)};
        const auto least = static_cast<std::uint32_t>(std::ranges::min_element(shares) - shares.begin());
        const std::uint32_t twin = mesh.twin(SurfaceTriangulation::edge(piece.triangle, (least + 1) % 3));
        is_lost = beyond == 3 || (beyond > 0 && shares[least] < 0) || step == kMaxSteps;
        if (shares[least] >= 0 || twin == kNone || twin / 4 == from || step == kMaxSteps) break;
        from = piece.triangle;
        piece.triangle = twin / 4;
    }
    for (double& share : shares) share = std::max(share, 0.0);
    const double sum = shares[0] + shares[1] + shares[2];
    if (!(sum > 0)) return {{1.0 / 3, 1.0 / 3, 1.0 / 3}, is_lost};
    return {{shares[0] / sum, shares[1] / sum, shares[2] / sum}, is_lost};
}

std::vector<double> SiteMasses::measure(const SurfaceTriangulation& mesh) {
    if (!is_located_) first_ = first_triangles(mesh);
    std::vector<std::array<double, 3>> shares(pieces_.size());
    for_ranges(mesh.executor(), pieces_.size(), kPieces, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            Piece& piece = pieces_[i];
            // A large face may have many sites, so that a search begins at the previous piece.
            const bool is_next = i > begin && piece.face == pieces_[i - 1].face;
            if (!is_located_) piece.triangle = is_next ? pieces_[i - 1].triangle : first_[piece.face];
            if (piece.triangle == kNone) continue;
            Located located = locate(mesh, piece);
            for (const std::uint32_t start : {is_next ? pieces_[i - 1].triangle : kNone, first_[piece.face]}) {
                if (!located.is_lost || start == kNone) continue;
                piece.triangle = start;
                located = locate(mesh, piece);
            }
            shares[i] = located.shares;
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
