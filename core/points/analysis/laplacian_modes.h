// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "core/base/result.h"
#include "core/geometry/point3.h"

// Matrices by Eigen, which only laplacian_modes.cpp includes.
namespace ccdt {

/// Eigenvectors of the Laplace-Beltrami operator with the lowest eigenvalues, without the constant one. They are
/// orthogonal, and the mean square of each over the area is 1.
struct LaplacianModes {
    std::vector<double> eigenvalues;  ///< [modes] ascending, per squared unit of length
    std::vector<double> values;       ///< [modes][vertices]
};

/// Computes modes by linear finite elements: the stiffness matrix contains the cotangents of angles. Borders are free,
/// that is, derivatives across them are 0. If there are c components, c - 1 modes have the eigenvalue 0.
///
/// @param vertices   [n] each one belongs to a triangle
/// @param triangles  with corners at different positions
/// @param count      number of modes, at most n / 5
/// @param stop       polled before each solution of linear equations
///
/// Errors: Unusable if the eigenvectors do not converge; Stopped. Deterministic. Modes with the same eigenvalue are an
/// arbitrary basis of their space. O(n count^2) and about 40 n count bytes. 100 modes of 35,000 vertices
/// take 6 s and 160 MB.
/// Source: Grimes, Lewis, Simon, A shifted block Lanczos algorithm for solving sparse symmetric generalized
/// eigenproblems, SIAM Journal on Matrix Analysis 15 (1994). Departures: one shift; restarts keep the best part of the
/// basis (Wu, Simon 2000).
Result<LaplacianModes> find_laplacian_modes(std::span<const Point3> vertices,
                                            std::span<const std::array<std::uint32_t, 3>> triangles, std::size_t count,
                                            const std::stop_token& stop = {});

}  // namespace ccdt
