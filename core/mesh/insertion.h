// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/geometry/point.h"
#include "core/mesh/triangulation.h"

// Inserts sites into a mesh, before trim().
namespace ccdt {

/// Inserts a site and restores the constrained Delaunay property around it. Fastest near the previously inserted site.
/// @param p       on a torus, rounded to a multiple of 2^-50
/// @param margin  least distance from the edges of the border
/// @returns       false, without inserting the site, if `p` is not strictly inside the domain, is too close to its
///                border, or coincides with a vertex
bool insert_site(Triangulation& mesh, std::uint32_t site, Point p, double margin = 0);

/// Returns the position to try for a site at an attempt, counted from 0. Several threads may call it at once.
using Draw = std::function<Point(std::uint32_t site, int attempt)>;

/// Inserts sites, each at the first of several positions that insert_site() accepts.
/// @param sites     numbers of the sites to insert, ascending and evenly spread over all sites; other calls insert the
///                  sites in between
/// @param attempts  number of positions to try for each site
/// @param margin    least distance from the edges of the border
/// @param stop      polled regularly; after a stop the triangulation must not be used
/// @returns         the sites for which no position was accepted; they must be inserted before trim()
std::vector<std::uint32_t> insert_sites(Triangulation& mesh, std::span<const std::uint32_t> sites, const Draw& draw,
                                        int attempts, double margin, const std::stop_token& stop = {});

/// Returns the part of the domain at a position; kNone outside the domain. Not for a torus; only before trim().
std::uint32_t part_at(Triangulation& mesh, Point p);

}  // namespace ccdt
