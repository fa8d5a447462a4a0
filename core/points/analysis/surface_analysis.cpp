// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/points/analysis/surface_analysis.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <unordered_map>
#include <utility>

#include "core/geometry/hexagonal_spacing.h"
#include "core/points/analysis/laplacian_modes.h"
#include "core/points/analysis/spacing.h"

namespace ccdt {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

constexpr double kLow = 0.5;                  // frequencies below this count as low
constexpr std::size_t kVerticesPerMode = 20;  // the shortest waves then have about 8 vertices per wavelength

/// Number of divisions of all triangles of a surface into four, and the number of vertices after them.
struct Division {
    int levels = 0;
    std::size_t vertices = 0;
};

Division plan_division(const Surface& surface, std::size_t modes) {
    Division division{0, surface.vertex_count()};
    std::size_t borders = surface.border_edges();
    for (std::size_t faces = surface.face_count(); division.vertices < kVerticesPerMode * modes; faces *= 4) {
        division.vertices += (3 * faces + borders) / 2;
        borders *= 2;
        ++division.levels;
    }
    return division;
}

/// Triangles that divide the faces of a surface. The triangles of face i are numbered from i * 4^levels.
struct FineMesh {
    std::vector<Point3> vertices;
    std::vector<Triangle> triangles;
    int levels = 0;

    explicit FineMesh(const Surface& surface) {
        for (std::uint32_t v = 0; v < surface.vertex_count(); ++v) vertices.push_back(surface.vertex(v));
        for (std::uint32_t f = 0; f < surface.face_count(); ++f) triangles.push_back(surface.corners(f));
    }

    /// Replaces every triangle by four. The first three share a corner with it, at the same index.
    void divide() {
        std::unordered_map<std::uint64_t, std::uint32_t> middles;
        const auto middle = [&](std::uint32_t a, std::uint32_t b) {
            const auto [low, high] = std::minmax(a, b);
            const auto [at, is_new] =
                middles.try_emplace(std::uint64_t{low} << 32 | high, static_cast<std::uint32_t>(vertices.size()));
            if (is_new) vertices.push_back(0.5 * (vertices[low] + vertices[high]));
            return at->second;
        };
        std::vector<Triangle> fine;
        fine.reserve(4 * triangles.size());
        for (const auto& [a, b, c] : triangles) {
            const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
            fine.insert(fine.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {bc, ca, ab}});
        }
        triangles = std::move(fine);
        ++levels;
    }

    /// Returns the same position, relative to one of the small triangles.
    SurfacePoint locate(SurfacePoint p) const {
        for (int level = 0; level < levels; ++level) {
            const auto nearest = std::ranges::max_element(p.weights);
            const bool at_corner = *nearest > 0.5;
            const auto corner = static_cast<std::size_t>(nearest - p.weights.begin());
            for (std::size_t i = 0; i < 3; ++i)
                p.weights[i] = at_corner ? 2 * p.weights[i] - (i == corner ? 1 : 0) : 1 - 2 * p.weights[i];
            p.face = 4 * p.face + static_cast<std::uint32_t>(at_corner ? corner : 3);
        }
        return p;
    }
};

/// Errors: those of find_laplacian_modes().
Result<void> add_modes(const Surface& surface, std::span<const SurfacePoint> points, std::size_t count,
                       const std::stop_token& stop, SurfaceAnalysis& analysis) {
    FineMesh mesh(surface);
    for (int levels = plan_division(surface, count).levels; mesh.levels < levels;) mesh.divide();
    auto modes = find_laplacian_modes(mesh.vertices, mesh.triangles, count, stop);
    if (!modes) return tl::unexpected(std::move(modes.error()));

    // Power depends on the points only through the sum of their weights at each vertex.
    std::vector<double> weights(mesh.vertices.size(), 0);
    for (const SurfacePoint& point : points) {
        const SurfacePoint fine = mesh.locate(point);
        for (std::size_t i = 0; i < 3; ++i) weights[mesh.triangles[fine.face][i]] += fine.weights[i];
    }
    const auto n = static_cast<double>(points.size());
    const double unit = 2 * std::numbers::pi * std::sqrt(n / surface.total_area());
    double low = 0, sum = 0;
    for (std::size_t k = 0; k < count; ++k) {
        const double* values = &modes->values[k * weights.size()];
        double total = 0;
        for (std::size_t v = 0; v < weights.size(); ++v) total += weights[v] * values[v];
        const double eigenvalue = std::max(0.0, modes->eigenvalues[k]);  // rounding may make 0 negative
        analysis.eigenvalues.push_back(eigenvalue / surface.scale() / surface.scale());
        analysis.frequency.push_back(std::sqrt(eigenvalue) / unit);
        analysis.power.push_back(total * total / n);
        if (analysis.frequency.back() >= kLow) continue;
        ++low;
        sum += analysis.power.back();
    }
    if (low > 0) analysis.low_frequency_power = sum / low;
    return {};
}

/// Errors: Unusable.
Result<void> add_spacing(const Surface& surface, std::span<const SurfacePoint> points, const std::stop_token& stop,
                         SurfaceAnalysis& analysis) {
    std::vector<Point3> positions, normals;
    for (const SurfacePoint& point : points) {
        positions.push_back(surface.position(point));
        normals.push_back(surface.normal(point.face));
    }
    const Spacing spacing = measure_spacing(positions, normals, stop);
    if (stop.stop_requested()) return failure(ErrorCode::Stopped, "the analysis was stopped");
    if (!std::isfinite(spacing.min)) return failure(ErrorCode::Unusable, "no point has a neighbour", "points");
    const double densest = hexagonal_spacing(static_cast<double>(points.size()) / surface.total_area());
    analysis.min_distance = spacing.min / densest;
    analysis.mean_distance = spacing.mean / densest;
    return {};
}

}  // namespace

std::size_t count_mode_vertices(const Surface& surface, std::size_t modes) {
    return plan_division(surface, modes).vertices;
}

Result<void> check_surface_analysis(std::size_t points, std::size_t modes) {
    if (points < 2) return failure(ErrorCode::Unusable, "at least 2 points are necessary", "points");
    if (modes >= 1 && modes <= kMaxModes) return {};
    return failure(ErrorCode::Malformed, "modes must be from 1 to " + std::to_string(kMaxModes), "modes");
}

Result<SurfaceAnalysis> analyse_surface(const Surface& surface, std::span<const SurfacePoint> points, std::size_t modes,
                                        const std::stop_token& stop) {
    if (auto checked = check_surface_analysis(points.size(), modes); !checked) return tl::unexpected(checked.error());
    const std::size_t vertices = count_mode_vertices(surface, modes);
    if (vertices > kMaxModeValues / modes)
        return failure(ErrorCode::LimitExceeded,
                       "for a surface with " + std::to_string(vertices) + " vertices, modes must be at most " +
                           std::to_string(kMaxModeValues / vertices),
                       "modes");
    SurfaceAnalysis analysis;
    return add_spacing(surface, points, stop, analysis)
        .and_then([&] { return add_modes(surface, points, modes, stop, analysis); })
        .map([&] { return std::move(analysis); });
}

}  // namespace ccdt
