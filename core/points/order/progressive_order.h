// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "core/base/executor.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"
#include "core/geometry/point3.h"

namespace ccdt {

/// Orders points progressively: for any k, the first k points are spread as evenly as possible, with the same relative
/// density as all points.
///
/// Points are removed one after another, and the result lists them in the reverse order of their removal. Each time,
/// the point with the largest excess in a region (see below) is removed. The excess of a point is its crowding plus
/// half of the surplus of points around it. The crowding is the sum of (1 - d / r)^5 over all neighbours at distances d
/// < r. Here, h is the distance of neighbours in a hexagonal grid with the local density of the remaining points, and r
/// is 1.7 h to 2 h. The surplus is smoothed by splines on a grid whose cells are about 3 h wide at the mean density. If
/// two points are nearer to each other than 0.58 h, one of them is removed before all other points. If the density is
/// uniform, such pairs are counted ahead: where more pairs become too near than there are removals, the removal of
/// their points begins earlier.
///
/// No part of the domain should lose a larger share of its points than another part. So the domain is recursively
/// halved into regions with nearly equal numbers of points, and the regions lose points in turn. As points are removed,
/// regions are merged, so that about 256 to 511 points remain in each.
///
/// @param domain    on a torus distances are periodic; of any other domain, only the bounding box and the area are used
/// @param points    [n], in the domain's bounding box; may coincide. Of those that do, one is ordered among the others,
///                  and the second, third and further ones follow after all others
/// @param uniform   whether the points have the same density everywhere in the domain; otherwise, the density is
///                  measured from the points
/// @param stop      polled regularly; a stop is not an error, but the returned permutation must not be used
/// @param executor  runs the tasks that compute crowding and densities
/// @returns         indices [n]: a permutation
///
/// Deterministic for any number of threads. O(n log n).
///
/// Source: Yuksel 2015, "Sample elimination for generating Poisson disk sample sets". Departures: r grows each time 30%
/// of the remaining points have been removed, not only after each halving; the surplus, which suppresses long waves;
/// the least distance of 0.58 h, and its plan; the regions; a density that is measured from the points.
std::vector<std::uint32_t> progressive_order(const Domain& domain, std::span<const Point> points, bool uniform,
                                             const std::stop_token& stop = {}, Executor& executor = inline_executor());

/// Orders points on the globe progressively. Points are given by longitude and latitude in degrees. Uses a conformal
/// chart around the centre of the points.
std::vector<std::uint32_t> progressive_order_on_globe(std::span<const Point> points, const std::stop_token& stop = {},
                                                      Executor& executor = inline_executor());

/// Orders points on a surface progressively, like points in the plane. Distances are those in space. Points whose
/// normals are more than 90 degrees apart are not neighbours: they are on opposite sides of a thin plate.
/// @param points   [n] may coincide
/// @param normals  [n] normals of the surface at the points, of unit length
/// @param area     area of the surface
/// @param uniform  whether the points have the same density everywhere; otherwise, the density is measured
/// @param closed   whether the surface has no border. Near borders, the density is measured even if it is uniform,
///                 because points there have fewer neighbours
std::vector<std::uint32_t> progressive_order_on_surface(std::span<const Point3> points, std::span<const Point3> normals,
                                                        double area, bool uniform, bool closed,
                                                        const std::stop_token& stop = {},
                                                        Executor& executor = inline_executor());

/// Orders points in space progressively, like points in the plane. Distances are relative to the face-centred cubic
/// lattice, the densest packing.
/// @param box       a box around the domain, with sides > 0
/// @param is_torus  whether the opposite faces of the box are joined
/// @param points    [n], in the box; may coincide
/// @param share     share of the box that the domain fills, in (0, 1]
/// @param uniform   whether the points have the same density everywhere in the domain
std::vector<std::uint32_t> progressive_order_in_space(const Box3& box, bool is_torus, std::span<const Point3> points,
                                                      double share, bool uniform, const std::stop_token& stop = {},
                                                      Executor& executor = inline_executor());

}  // namespace ccdt
