// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <vector>

#include "core/base/result.h"
#include "core/ccdt/maps/map_feature.h"
#include "core/ccdt/plane/ccdt.h"
#include "core/density/density.h"
#include "core/geometry/point.h"

namespace ccdt {

/// Distributes the given number of dots evenly in each feature, and evenly across the borders between features. No dot
/// leaves its feature. The distance between neighbours in two features lies between the spacings of these features.
/// Overlapping features each keep their dots. Each class is evenly distributed, and dots of different classes keep
/// apart.
///
/// Each class has one triangulation. It covers the union of all features that have dots of this class, and its sites
/// are these dots. Each dot has a disc whose diameter is the distance that neighbours should have at this position. The
/// target of a triangle follows from the discs of its corners. A move that would leave a feature slides along its
/// border instead. Long waves of density error are removed across borders between similar densities; at other borders,
/// they are removed on each side separately.
///
/// @param features  all with the same number of classes; together they have at least one dot
/// @param box       box over which the density is stretched
/// @param density   wanted density, relative to other places in the same feature
/// @param options   `sites` is ignored, because features give the numbers of dots; no mesh is kept
/// @param control   as in distribute_inks(); a stop returns the current dots, which is not an error; a stop during the
///                  start gives the error Stopped
/// @returns         [classes]
///
/// Errors: as for distribute(); Unusable with the field `features/i` if a density is zero everywhere in a feature that
/// has dots, or if a feature is too thin to hold points strictly inside. Deterministic. O(dots log c) per pass, where c
/// is the number of the features' corners.
Result<std::vector<ClassDots>> distribute_dots(std::span<const MapFeature> features, const Box& box,
                                               const Density& density, const Options& options,
                                               const Control& control = {});

}  // namespace ccdt
