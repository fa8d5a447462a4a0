// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/surface/surface_density.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numeric>
#include <string>
#include <utility>

#include "core/halftone/srgb.h"

namespace ccdt {

namespace {

/// Returns the cotangents of a face's angles, each opposite to the edge with the same number.
std::array<double, 3> opposite_cotangents(const Surface& surface, std::uint32_t face) {
    constexpr double kLargest = 1e3;  // of faces almost without area
    const auto places = surface.places(face);
    std::array<double, 3> cotangents{};
    for (std::size_t k = 0; k < 3; ++k) {
        const Point3 apex = places[(k + 2) % 3];
        const double product = dot(places[k] - apex, places[(k + 1) % 3] - apex);
        if (surface.area(face) > 0) {
            cotangents[k] = std::clamp(product / (2 * surface.area(face)), -kLargest, kLargest);
        }
    }
    return cotangents;
}

double inner_product(std::span<const Point3> a, std::span<const Point3> b) {
    return std::inner_product(a.begin(), a.end(), b.begin(), 0.0, std::plus{}, dot);
}

/// Smooths vectors at the vertices: solves (M + spacing^2 L) x = M b by conjugate gradients, where M contains the areas
/// of the vertices and L is the cotangent Laplacian without negative weights.
class Smoothing {
public:
    Smoothing(const Surface& surface, double spacing) : areas_(surface.vertex_count()) {
        for (std::uint32_t f = 0; f < surface.face_count(); ++f) {
            const auto corners = surface.corners(f);
            const auto cotangents = opposite_cotangents(surface, f);
            for (std::size_t k = 0; k < 3; ++k) {
                areas_[corners[k]] += surface.area(f) / 3;
                if (cotangents[k] > 0) {
                    links_.push_back({corners[k], corners[(k + 1) % 3], spacing * spacing * cotangents[k] / 2});
                }
            }
        }
        diagonal_ = areas_;
        for (const Link& link : links_) {
            diagonal_[link.a] += link.weight;
            diagonal_[link.b] += link.weight;
        }
    }

    double area(std::uint32_t vertex) const { return areas_[vertex]; }

    std::vector<Point3> apply(std::vector<Point3> x) const {
        constexpr int kMaxSteps = 100;
        constexpr double kTolerance = 1e-8;  // of the squared residual
        std::vector<Point3> residual = image(x);
        for (std::size_t v = 0; v < x.size(); ++v) residual[v] = areas_[v] * x[v] - residual[v];
        std::vector<Point3> scaled = preconditioned(residual), direction = scaled;
        double size = inner_product(residual, scaled);
        const double enough = kTolerance * size;
        for (int step = 0; step < kMaxSteps && size > enough; ++step) {
            const std::vector<Point3> change = image(direction);
            const double length = size / inner_product(direction, change);
            for (std::size_t v = 0; v < x.size(); ++v) {
                x[v] = x[v] + length * direction[v];
                residual[v] = residual[v] - length * change[v];
            }
            scaled = preconditioned(residual);
            const double ratio = inner_product(residual, scaled) / size;
            size *= ratio;
            for (std::size_t v = 0; v < x.size(); ++v) direction[v] = scaled[v] + ratio * direction[v];
        }
        return x;
    }

private:
    struct Link {
        std::uint32_t a, b;
        double weight;
    };

    std::vector<Point3> image(std::span<const Point3> x) const {
        std::vector<Point3> result(x.size());
        for (std::size_t v = 0; v < x.size(); ++v) result[v] = areas_[v] * x[v];
        for (const Link& link : links_) {
            const Point3 flow = link.weight * (x[link.a] - x[link.b]);
            result[link.a] = result[link.a] + flow;
            result[link.b] = result[link.b] - flow;
        }
        return result;
    }
    std::vector<Point3> preconditioned(std::vector<Point3> x) const {
        for (std::size_t v = 0; v < x.size(); ++v) x[v] = (diagonal_[v] > 0 ? 1 / diagonal_[v] : 0) * x[v];
        return x;
    }

    std::vector<double> areas_, diagonal_;
    std::vector<Link> links_;
};

}  // namespace

Result<SurfaceDensity> SurfaceDensity::of_soup(const Surface& surface, const TriangleSoup& soup,
                                               std::span<const double> values) {
    const double largest = *std::max_element(values.begin(), values.end());
    SurfaceDensity density;
    density.values_.resize(3 * surface.face_count());
    double total = 0;
    for (std::uint32_t f = 0; f < surface.face_count(); ++f) {
        const auto& corners = soup.triangles[surface.triangle_of(f)];
        for (std::size_t k = 0; k < 3; ++k) {
            SurfacePoint corner{f, {}};
            corner.weights[k] = 1;
            const auto weights = surface.original_weights(corner);
            const auto original = std::find(weights.begin(), weights.end(), 1) - weights.begin();
            density.values_[3 * std::size_t{f} + k] = values[corners[static_cast<std::size_t>(original)]] / largest;
        }
        total += density.mass(surface, f);
    }
    if (!(total > 0)) return failure(ErrorCode::Unusable, "the density is zero all over the surface", "density");
    return density;
}

Result<SurfaceDensity> SurfaceDensity::of_vertices(const Surface& surface, const TriangleSoup& soup,
                                                   std::span<const double> values) {
    if (values.size() != soup.vertices.size()) {
        return failure(ErrorCode::Malformed,
                       "there are " + std::to_string(values.size()) + " densities, but " +
                           std::to_string(soup.vertices.size()) + " vertices",
                       "density");
    }
    for (std::size_t v = 0; v < values.size(); ++v) {
        if (values[v] >= 0 && std::isfinite(values[v])) continue;
        return failure(ErrorCode::Malformed, "a density is negative or not finite", "density/" + std::to_string(v));
    }
    return of_soup(surface, soup, values);
}

Result<SurfaceDensity> SurfaceDensity::of_colours(const Surface& surface, const TriangleSoup& soup) {
    if (soup.colours.empty()) return failure(ErrorCode::Unusable, "the vertices have no colours", "density");
    std::vector<double> values(soup.colours.size());
    std::transform(soup.colours.begin(), soup.colours.end(), values.begin(), [](const std::array<float, 3>& colour) {
        const auto [red, green, blue] = colour;
        return std::clamp(1 - luminance_of<double>(red, green, blue), 0.0, 1.0);
    });
    return of_soup(surface, soup, values);
}

SurfaceDensity SurfaceDensity::of_curvature(const Surface& surface, double spacing, double contrast) {
    const Smoothing smoothing(surface, spacing);
    std::vector<Point3> normals(surface.vertex_count());
    for (std::uint32_t v = 0; v < normals.size(); ++v) normals[v] = surface.vertex_normal(v);
    normals = smoothing.apply(std::move(normals));
    for (Point3& normal : normals) normal = 1 / std::max(length(normal), 1e-12) * normal;

    // Integrals of the squared curvatures over the faces around each vertex.
    std::vector<double> bending(normals.size());
    double total = 0;
    for (std::uint32_t f = 0; f < surface.face_count(); ++f) {
        const auto corners = surface.corners(f);
        const auto cotangents = opposite_cotangents(surface, f);
        double sum = 0;
        for (std::size_t k = 0; k < 3; ++k) {
            const Point3 change = normals[corners[(k + 1) % 3]] - normals[corners[k]];
            sum += cotangents[k] / 2 * dot(change, change);
        }
        sum = std::max(0.0, sum);
        total += sum;
        for (const std::uint32_t v : corners) bending[v] += sum / 3;
    }
    const double mean = total / surface.total_area();
    constexpr double kLeastMean = 1e-12;  // less is due to rounding: a radius of 1e6
    if (mean < kLeastMean) return uniform();
    SurfaceDensity density;
    density.values_.assign(3 * surface.face_count(), 1);
    for (std::uint32_t f = 0; f < surface.face_count(); ++f) {
        const auto corners = surface.corners(f);
        for (std::size_t k = 0; k < 3; ++k) {
            const double area = smoothing.area(corners[k]), squared = bending[corners[k]];
            if (area == 0) continue;
            density.values_[3 * std::size_t{f} + k] = 1 + (contrast - 1) * squared / (squared + mean * area);
        }
    }
    return density;
}

}  // namespace ccdt
