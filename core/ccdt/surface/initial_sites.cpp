// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/surface/initial_sites.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "core/base/random.h"
#include "core/ccdt/surface/face_pieces.h"
#include "core/geometry/apportion.h"
#include "core/geometry/morton.h"

namespace ccdt {

namespace {

/// Returns the faces, sorted by component and, within each component, along the space-filling curve.
std::vector<std::uint32_t> sorted_faces(const Surface& surface) {
    std::vector<std::uint32_t> order(surface.face_count());
    std::iota(order.begin(), order.end(), 0U);
    std::ranges::stable_sort(order, {}, [&](std::uint32_t f) { return surface.component(f); });
    return order;
}

/// Draws points in faces by a low-discrepancy sequence, with rejection where the density varies within the face. In
/// faces that are divided into pieces, draws them by systematic sampling of the pieces.
class FaceSampler {
public:
    FaceSampler(const Surface& surface, const SurfaceDensity& density, std::uint64_t seed)
        : surface_(surface), density_(density), seed_(seed) {}

    /// Appends `count` points in a face.
    void draw(std::uint32_t face, std::size_t count, std::vector<SurfacePoint>& points) const {
        if (count == 0) return;
        constexpr int kAttempts = 64;  // per point, on average; after them, the density is ignored
        Random random(seed_, std::uint64_t{1} << 32 | face);
        if (density_.side(face) > 1) return draw_in_pieces(face, count, random, points);
        double u = random.uniform(), v = random.uniform();
        const double highest = density_.largest(face);
        std::size_t attempts = kAttempts * count;
        for (std::size_t drawn = 0; drawn < count;) {
            u = wrap(u + kFirstStep);
            v = wrap(v + kSecondStep);
            const SurfacePoint point{face, position_in_triangle(u, v)};
            if (attempts > 0 && !density_.is_uniform()) {
                --attempts;
                if (random.uniform() * highest > density_.at(point)) continue;
            }
            points.push_back(point);
            ++drawn;
        }
    }

private:
    struct Piece {
        std::uint64_t key = 0;  ///< position of the centre along the space-filling curve
        std::array<double, 3> centre{};
    };

    void draw_in_pieces(std::uint32_t face, std::size_t count, Random& random,
                        std::vector<SurfacePoint>& points) const {
        const std::uint32_t side = density_.side(face);
        std::vector<Piece> pieces;
        double total = 0;
        for_face_pieces(side, [&](const std::array<double, 3>& centre) {
            pieces.push_back({morton_position(surface_.position({face, centre})), centre});
            total += density_.at({face, centre});
        });
        std::ranges::sort(pieces, {}, [](const Piece& piece) { return std::pair(piece.key, piece.centre); });
        const double offset = random.uniform();
        double sum = 0;
        std::size_t drawn = 0;
        for (const Piece& piece : pieces) {
            sum += density_.at({face, piece.centre});
            const bool is_last = &piece == &pieces.back();
            const auto until =
                is_last ? count : static_cast<std::size_t>(sum / total * static_cast<double>(count) + offset);
            for (; drawn < std::min(until, count); ++drawn) {
                // A random point near the centre of the piece, and inside the piece.
                const double u = (random.uniform() - 0.5) / (3 * side), v = (random.uniform() - 0.5) / (3 * side);
                const auto& [a, b, c] = piece.centre;
                points.push_back({face, {a - u - v, b + u, c + v}});
            }
        }
    }

    static double wrap(double value) { return value >= 1 ? value - 1 : value; }

    const Surface& surface_;
    const SurfaceDensity& density_;
    std::uint64_t seed_;
};

/// Returns the number of sites of each component, rounded by apportion().
std::vector<std::size_t> shares(const Surface& surface, const SurfaceDensity& density, std::size_t sites) {
    constexpr double kThird = 1.0 / 3;
    std::vector<double> quotas(surface.component_count(), 0);
    std::vector<Point3> centroids(quotas.size());
    double total = 0;
    for (std::uint32_t f = 0; f < surface.face_count(); ++f) {
        const double mass = density.mass(surface, f);
        if (!(mass > 0)) continue;
        const std::uint32_t component = surface.component(f);
        Point3& centroid = centroids[component];
        total += mass;
        quotas[component] += mass;
        const Point3 middle = surface.position({f, {kThird, kThird, kThird}});
        centroid = centroid + (mass / quotas[component]) * (middle - centroid);
    }
    for (double& quota : quotas) quota *= total > 0 ? static_cast<double>(sites) / total : 0;
    return std::move(apportion(centroids, {&quotas, 1}).front());
}

}  // namespace

std::vector<SurfacePoint> initial_sites(const Surface& surface, const SurfaceDensity& density, std::size_t sites,
                                        std::uint64_t seed) {
    const auto faces = sorted_faces(surface);
    const auto counts = shares(surface, density, sites);
    const FaceSampler sampler(surface, density, seed);
    Random random(seed, 0);
    std::vector<SurfacePoint> drawn;
    drawn.reserve(sites);
    for (std::size_t first = 0, end = 0; first < faces.size(); first = end) {
        const std::uint32_t component = surface.component(faces[first]);
        double total = 0;
        for (end = first; end < faces.size() && surface.component(faces[end]) == component; ++end)
            total += density.mass(surface, faces[end]);
        const std::size_t wanted = counts[component];
        const double offset = random.uniform();
        double sum = 0;
        std::size_t given = 0;
        std::uint32_t heaviest = faces[first];
        for (std::size_t i = first; i < end && total > 0; ++i) {
            const double mass = density.mass(surface, faces[i]);
            if (mass > density.mass(surface, heaviest)) heaviest = faces[i];
            sum += mass;
            const auto until = static_cast<std::size_t>(sum / total * static_cast<double>(wanted) + offset);
            const std::size_t here = std::min(std::max(until, given), wanted) - given;
            sampler.draw(faces[i], here, drawn);
            given += here;
        }
        sampler.draw(heaviest, wanted - given, drawn);
    }
    std::vector<std::pair<std::uint64_t, std::uint32_t>> keys(drawn.size());
    for (std::uint32_t i = 0; i < drawn.size(); ++i) keys[i] = {morton_position(surface.position(drawn[i])), i};
    std::ranges::sort(keys);
    std::vector<SurfacePoint> sorted;
    sorted.reserve(drawn.size());
    for (const auto& [key, i] : keys) sorted.push_back(drawn[i]);
    return sorted;
}

}  // namespace ccdt
