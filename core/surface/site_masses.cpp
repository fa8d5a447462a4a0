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
        for_face_pieces(side, [&](const std::array<double, 3>& weights) {
            const SurfacePoint at{f, weights};
            const double piece = area * density.at(at);
            if (piece > 0) pieces_.push_back({surface.place(at), piece, f, kNone});
        });
    }
}

/// Chooses the triangle at which the first search for each piece begins: a triangle at a site on the nearest face that
/// has sites. Distances between faces are counted in edges that are not creases.
void SiteMasses::find_first(const SurfaceTriangulation& mesh) {
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
    for (Piece& piece : pieces_) piece.triangle = near[piece.face];
}

/// Walks to the triangle above a piece. Returns the shares of its corners.
std::array<double, 3> SiteMasses::locate(const SurfaceTriangulation& mesh, Piece& piece) {
    constexpr int kMaxSteps = 256;  // a walk on a bent surface may not end
    std::array<double, 3> shares{};
    std::uint32_t from = kNone;
    for (int step = 0;; ++step) {
        const Point3 normal = mesh.doubled_normal(piece.triangle);
        auto places = mesh.places(piece.triangle);
        for (Point3& place : places) place = place - piece.place;
        const auto& [a, b, c] = places;
        shares = {dot(cross(b, c), normal), dot(cross(c, a), normal), dot(cross(a, b), normal)};
        const auto least = static_cast<std::uint32_t>(std::ranges::min_element(shares) - shares.begin());
        const std::uint32_t twin = mesh.twin(SurfaceTriangulation::edge(piece.triangle, (least + 1) % 3));
        if (shares[least] >= 0 || twin == kNone || twin / 4 == from || step == kMaxSteps) break;
        from = piece.triangle;
        piece.triangle = twin / 4;
    }
    for (double& share : shares) share = std::max(share, 0.0);
    const double sum = shares[0] + shares[1] + shares[2];
    if (!(sum > 0)) return {1.0 / 3, 1.0 / 3, 1.0 / 3};
    return {shares[0] / sum, shares[1] / sum, shares[2] / sum};
}

std::vector<double> SiteMasses::measure(const SurfaceTriangulation& mesh) {
    if (!is_located_) find_first(mesh);
    std::vector<std::array<double, 3>> shares(pieces_.size());
    for_ranges(mesh.executor(), pieces_.size(), kPieces, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            if (pieces_[i].triangle == kNone) continue;
            if (!is_located_ && i > begin && pieces_[i].face == pieces_[i - 1].face)
                pieces_[i].triangle = pieces_[i - 1].triangle;  // a large face may have many sites
            shares[i] = locate(mesh, pieces_[i]);
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
