// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/base/result.h"
#include "core/ccdt/surface/surface.h"

namespace ccdt {

/// Spacing of points on a surface, and their power in the modes of the surface. The modes are the eigenfunctions of the
/// Laplace-Beltrami operator. They are the waves of the surface, as sines and cosines are the waves of a torus.
struct SurfaceAnalysis {
    std::vector<double> eigenvalues;  ///< [modes] ascending, in the coordinates of the soup; without the constant mode
    std::vector<double> frequency;    ///< [modes] sqrt(eigenvalue) / (2 pi), in units of sqrt(n / area)
    std::vector<double> power;        ///< [modes] |sum over points of phi|^2 / n; random points have power 1

    /// Mean power of the modes whose frequency is below 0.5; empty if there are no such modes.
    std::optional<double> low_frequency_power;

    /// Least and mean distance of points from their nearest neighbours, by measure_spacing() with normals.
    /// The unit is the hexagonal distance for n points on this area.
    double min_distance = 0;
    double mean_distance = 0;
};

inline constexpr std::size_t kMaxModes = 500;

/// Largest number of values of modes, that is, the number of modes times the number of vertices.
inline constexpr std::size_t kMaxModeValues = std::size_t{1} << 25;

/// Returns the number of vertices on which modes are computed. A coarse surface is divided: every triangle is replaced
/// by four, until there are at least 20 vertices per mode.
std::size_t count_mode_vertices(const Surface& surface, std::size_t modes);

/// Checks the number of points and the number of modes. Errors: those of analyse_surface() for numbers out of range.
Result<void> check_surface_analysis(std::size_t points, std::size_t modes);

/// Measures points on a surface.
///
/// @param points  [n], n >= 2
/// @param modes   number of modes, 1 to kMaxModes
///
/// Errors: Malformed for a number of modes out of range ("modes"); LimitExceeded if the modes would have more than
/// kMaxModeValues values ("modes"); Unusable for too few points ("points"), or if no point has a neighbour; those of
/// find_laplacian_modes(). Deterministic. If several modes have the same eigenvalue, only the sum of their powers has a
/// meaning. Takes the time of find_laplacian_modes() and O(n (modes + log n)).
/// Source: Lagae and Dutre 2008, for the units. Departure: modes of the surface replace Fourier's.
Result<SurfaceAnalysis> analyse_surface(const Surface& surface, std::span<const SurfacePoint> points, std::size_t modes,
                                        const std::stop_token& stop = {});

}  // namespace ccdt
