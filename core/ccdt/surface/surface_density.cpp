// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/ccdt/surface/surface_density.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <string>
#include <utility>

#include "core/ccdt/surface/face_pieces.h"
#include "core/picture/srgb.h"

namespace ccdt {

namespace {

/// Returns the cotangents of a face's angles, each opposite to the edge with the same number.
std::array<double, 3> opposite_cotangents(const Surface& surface, std::uint32_t face) {
    constexpr double kLargest = 1e3;  // of faces almost without area
    const auto positions = surface.positions(face);
    std::array<double, 3> cotangents{};
    for (std::size_t k = 0; k < 3; ++k) {
        const Point3 apex = positions[(k + 2) % 3];
        const double product = dot(positions[k] - apex, positions[(k + 1) % 3] - apex);
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

    std::vector<Point3> apply(std::vector<Point3> x, const std::stop_token& stop) const {
        constexpr int kMaxSteps = 100;
        constexpr double kTolerance = 1e-8;  // of the squared residual
        std::vector<Point3> residual = image(x);
        for (std::size_t v = 0; v < x.size(); ++v) residual[v] = areas_[v] * x[v] - residual[v];
        std::vector<Point3> scaled = preconditioned(residual), direction = scaled;
        double size = inner_product(residual, scaled);
        const double enough = kTolerance * size;
        for (int step = 0; step < kMaxSteps && size > enough && !stop.stop_requested(); ++step) {
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

/// Corners of the piece of a face that contains a point, and barycentric coordinates in the piece. Corners are numbered
/// in rows from the first side of the face.
struct InPiece {
    std::array<std::size_t, 3> corners;
    std::array<double, 3> weights;

    /// Returns the index of the corner at (i / n, j / n) in the second and third barycentric coordinates.
    static std::size_t corner(std::size_t n, std::size_t i, std::size_t j) { return j * (2 * n + 3 - j) / 2 + i; }

    InPiece(std::uint32_t side, const std::array<double, 3>& at) {
        const std::size_t n = side;
        const auto whole = [](double value, std::size_t most) {
            return std::min(static_cast<std::size_t>(std::max(value, 0.0)), most);
        };
        const double along = at[1] * side, across = at[2] * side;
        const std::size_t i = whole(along, n - 1), j = whole(across, n - 1 - i);
        const double u = along - static_cast<double>(i), v = across - static_cast<double>(j);
        const std::size_t own = corner(n, i, j), above = corner(n, i, j + 1);
        const bool is_upside_down = u + v > 1 && i + j + 1 < n;
        corners = {is_upside_down ? above + 1 : own, own + 1, above};
        weights = is_upside_down ? std::array{u + v - 1, 1 - v, 1 - u} : std::array{1 - u - v, u, v};
    }
};

double darkness_at(const Surface& surface, const TriangleSoup& soup, const SurfacePoint& point) {
    const auto [red, green, blue, alpha] =
        soup.colour_at(surface.triangle_of(point.face), surface.original_weights(point));
    return std::clamp(1 - luminance_of<double>(red, green, blue), 0.0, 1.0) * std::clamp<double>(alpha, 0, 1);
}

double longest_side(const std::array<Point3, 3>& corners) {
    const auto& [a, b, c] = corners;
    return std::max({length(b - a), length(c - b), length(a - c)});
}

/// Chooses the number of pieces along the sides of each face.
std::vector<std::uint32_t> choose_sides(const Surface& surface, const TriangleSoup& soup, double spacing) {
    constexpr double kPiece = 0.5;     // side of a piece, relative to the spacing
    constexpr double kMaxSide = 8192;  // pieces
    constexpr double kPerSite = 64;    // largest mean number of pieces per site; thin faces need more than others
    const double most =
        static_cast<double>(surface.face_count()) + kPerSite * surface.total_area() / (spacing * spacing);
    std::vector<std::uint32_t> sides(surface.face_count(), 1);
    for (double piece = kPiece * spacing;; piece *= 2) {
        double total = 0;
        for (std::uint32_t f = 0; f < sides.size(); ++f) {
            if (soup.has_picture(surface.triangle_of(f)))
                sides[f] = static_cast<std::uint32_t>(
                    std::clamp(std::ceil(longest_side(surface.positions(f)) / piece), 1.0, kMaxSide));
            total += static_cast<double>(sides[f]) * sides[f];
        }
        if (!(total > most)) return sides;
    }
}

/// Returns the number of samples along each side of a piece: about the number of texels, limited to 2 to 4.
std::uint32_t samples_per_side(const TriangleSoup& soup, std::uint32_t triangle, std::uint32_t side) {
    constexpr double kMin = 2, kMax = 4;
    const auto position = [&](const std::array<double, 3>& weights) {
        const auto [x, y] = soup.texel_at(triangle, weights);
        return Point3{x, y, 0};
    };
    const double texels = longest_side({position({1, 0, 0}), position({0, 1, 0}), position({0, 0, 1})});
    return static_cast<std::uint32_t>(std::max(kMin, std::min(std::ceil(texels / side), kMax)));
}

}  // namespace

double SurfaceDensity::at(const SurfacePoint& point) const {
    if (values_.empty()) return 1;
    const auto [first, side, mean] = grid(point.face);
    const InPiece in(side, point.weights);
    double value = 0;
    for (std::size_t k = 0; k < 3; ++k) value += in.weights[k] * values_[first + in.corners[k]];
    return value;
}

double SurfaceDensity::largest(std::uint32_t face) const {
    if (values_.empty()) return 1;
    const auto [first, side, mean] = grid(face);
    const std::size_t count = (std::size_t{side} + 1) * (side + 2) / 2;
    return *std::max_element(&values_[first], &values_[first] + count);
}

double SurfaceDensity::largest(std::uint32_t face, const std::array<std::array<double, 3>, 3>& corners) const {
    if (values_.empty()) return 1;
    const auto [first, side, mean] = grid(face);
    std::array<std::size_t, 3> least, most;  // coordinates of the corners of pieces
    for (std::size_t k = 0; k < 3; ++k) {
        const auto [low, high] = std::minmax({corners[0][k], corners[1][k], corners[2][k]});
        least[k] = static_cast<std::size_t>(std::max(0.0, std::floor(low * side)));
        most[k] = static_cast<std::size_t>(std::clamp(std::ceil(high * side), 0.0, static_cast<double>(side)));
    }
    double value = 0;
    for (std::size_t j = least[2]; j <= most[2]; ++j) {
        for (std::size_t i = least[1]; i <= most[1] && i + j + least[0] <= side; ++i) {
            if (i + j + most[0] >= side) value = std::max(value, values_[first + InPiece::corner(side, i, j)]);
        }
    }
    return value;
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
    const double largest =
        std::max(*std::max_element(values.begin(), values.end()), std::numeric_limits<double>::min());
    SurfaceDensity density;
    density.values_.reserve(3 * std::size_t{surface.face_count()});
    for (std::uint32_t f = 0; f < surface.face_count(); ++f) {
        auto corners = soup.triangles[surface.triangle_of(f)];
        if (surface.is_turned(f)) std::swap(corners[1], corners[2]);
        for (const std::uint32_t v : corners) density.values_.push_back(values[v] / largest);
    }
    return density;
}

Result<SurfaceDensity> SurfaceDensity::of_colours(const Surface& surface, const TriangleSoup& soup, double spacing,
                                                  const std::stop_token& stop) {
    if (!soup.has_colours()) return failure(ErrorCode::Unusable, "the mesh has no colours", "density");
    const auto sides = choose_sides(surface, soup, spacing);
    SurfaceDensity density;
    std::vector<double> weights;  // of the samples around each corner of a piece
    for (std::uint32_t f = 0; f < surface.face_count(); ++f) {
        const std::size_t first = density.values_.size(), side = sides[f], count = (side + 1) * (side + 2) / 2;
        density.values_.resize(first + count, 0);
        const std::span<double> values = std::span(density.values_).subspan(first);
        if (soup.has_picture(surface.triangle_of(f))) {
            weights.assign(count, 0);
            const auto samples = samples_per_side(soup, surface.triangle_of(f), sides[f]);
            const auto add = [&](const std::array<double, 3>& at) {
                const double darkness = darkness_at(surface, soup, {f, at});
                const InPiece in(sides[f], at);
                for (std::size_t k = 0; k < 3; ++k) {
                    values[in.corners[k]] += in.weights[k] * darkness;
                    weights[in.corners[k]] += in.weights[k];
                }
            };
            for_face_pieces(sides[f] * samples, add, stop);
            for (std::size_t i = 0; i < count; ++i) values[i] /= weights[i];
        } else {
            for (std::size_t k = 0; k < 3; ++k) values[k] = darkness_at(surface, soup, SurfacePoint::corner(f, k));
        }
        double mean = 0;
        for_face_pieces(sides[f], [&](const std::array<double, 3>& at) {
            for (const std::size_t corner : InPiece(sides[f], at).corners)
                mean += values[corner] / static_cast<double>(3 * side * side);
        });
        density.grids_.push_back({first, sides[f], mean});
        if (stop.stop_requested())
            return failure(ErrorCode::Stopped, "stopped before the density was known", "density");
    }
    return density;
}

SurfaceDensity SurfaceDensity::of_curvature(const Surface& surface, double spacing, double contrast,
                                            const std::stop_token& stop) {
    const Smoothing smoothing(surface, spacing);
    std::vector<Point3> normals(surface.vertex_count());
    for (std::uint32_t v = 0; v < normals.size(); ++v) normals[v] = surface.vertex_normal(v);
    normals = smoothing.apply(std::move(normals), stop);
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
    constexpr double kMinMean = 1e-12;  // less is due to rounding: a radius of 1e6
    if (mean < kMinMean) return uniform();
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
