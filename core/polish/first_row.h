#pragma once

#include <span>

#include "core/geometry/point.h"
#include "core/mesh/triangulation.h"

namespace ccdt {

/// Takes from the moves of sites what would bring them nearer to the border than some depth; those that are nearer do
/// not come nearer still, and slide along it.
/// @param mesh      trimmed, not a torus'
/// @param spacings  [sites] 1 / sqrt(density of the sites that are wanted)
/// @param depth     in spacings
/// @param moves     in and out [sites]
void keep_off_border(const Triangulation& mesh, std::span<const double> spacings, double depth, std::span<Point> moves);

}  // namespace ccdt
