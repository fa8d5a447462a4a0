#pragma once

#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/ccdt/start.h"
#include "core/mesh/triangulation.h"
#include "core/result.h"

namespace ccdt {

/// Inserts all free sites of a mesh: where `first` has them; where no site can be there, as `start` draws them; where
/// next to nothing of a site's cell lies in parts with room, anywhere in the part that has most.
///
/// @param first   [sites], or empty: all as `start` draws them
/// @param room    [parts of the mesh] how many sites each shall hold, in all as many as there are; or empty: any
/// number.
///                A part too thin for its sites leaves them to others.
/// @param margin  least distance of a site from the border
/// @param stop    asked now and then
/// @returns       nothing when all are placed; Stopped; Unusable if the domain is too thin for points strictly inside
std::optional<Error> place_sites(Triangulation& mesh, std::span<const Point> first, const StartSites& start,
                                 std::vector<std::size_t> room, std::uint64_t seed, double margin,
                                 const std::stop_token& stop);

}  // namespace ccdt
