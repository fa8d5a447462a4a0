// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/base/result.h"
#include "core/ccdt/plane/start.h"
#include "core/mesh/triangulation.h"

namespace ccdt {

/// Inserts all free sites of a mesh. For each site, tries its position in `first`, then positions that `start` draws.
/// If almost none of the site's cell is usable, the site goes anywhere in the part that lacks most sites.
///
/// @param first      [sites], or empty if all positions come from `start`
/// @param vacancies  [parts of the mesh] number of sites for each part, adding up to all sites; or empty if parts may
///                   hold any number. Sites that do not fit into a thin part go to other parts.
/// @param margin     least distance of a site from the border
/// @param stop       polled regularly
/// @returns          none on success; else the error Stopped, or Unusable if the domain is too thin for points strictly
///                   inside
std::optional<Error> place_sites(Triangulation& mesh, std::span<const Point> first, const StartSites& start,
                                 std::vector<std::size_t> vacancies, std::uint64_t seed, double margin,
                                 const std::stop_token& stop);

}  // namespace ccdt
