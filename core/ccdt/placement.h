// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/ccdt/start.h"
#include "core/mesh/triangulation.h"
#include "core/result.h"

namespace ccdt {

/// Inserts all free sites of a mesh. A site is tried at its position in `first`; if that is rejected, where `start`
/// draws it. If almost none of its cell is usable, it goes anywhere in the part with most missing sites.
///
/// @param first      [sites], or empty: all positions come from `start`
/// @param vacancies  [parts of the mesh] number of sites for each part, adding up to all sites; or empty: any number.
///                   Sites that do not fit into a thin part go to others.
/// @param margin     least distance of a site from the border
/// @param stop       polled regularly
/// @returns          none if all sites are placed; Stopped; Unusable if the domain is too thin for points strictly
///                   inside
std::optional<Error> place_sites(Triangulation& mesh, std::span<const Point> first, const StartSites& start,
                                 std::vector<std::size_t> vacancies, std::uint64_t seed, double margin,
                                 const std::stop_token& stop);

}  // namespace ccdt
