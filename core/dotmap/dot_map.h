// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/ccdt/ccdt.h"
#include "core/density/density.h"
#include "core/geometry/domain.h"
#include "core/geometry/point.h"
#include "core/result.h"

namespace ccdt {

/// A part of a map with its own number of dots of each class.
struct MapFeature {
    Domain area;                    ///< not a torus
    std::vector<std::size_t> dots;  ///< [classes] number of dots
};

/// The dots of one class.
struct ClassDots {
    Distribution dots;                      ///< without mesh; points are sorted by feature
    std::vector<std::uint32_t> feature_of;  ///< [points] feature of each point
};

/// Distributes the given number of dots evenly in each feature, and evenly across the borders between features. No dot
/// leaves its feature. The distance of neighbours in two features lies between the spacings of both. Where features
/// overlap, there are the dots of both. The dots of each class are evenly distributed, and dots of different classes
/// keep apart.
///
/// All dots of a class are the sites of one triangulation of all ground that has dots. The target of a triangle follows
/// from the discs of its corners' dots, each as large as the dot's share of ground. Moves that would leave a feature
/// slide along its border instead. Long waves of density error are removed across borders between similar densities,
/// and within each feature otherwise.
///
/// @param features  all with the same number of classes, and at least one dot in all
/// @param box       box over which the density is stretched
/// @param density   wanted density, relative to other ground of the same feature
/// @param options   the number of sites is that of the features' dots; no mesh is kept
/// @param control   as in distribute_inks(); a stop returns the current dots, which is not an error; a stop during the
///                  start gives the error Stopped
/// @returns         [classes]
///
/// Errors: as distribute(); Unusable with the field `features/i` if a density is zero everywhere in a feature that has
/// dots, or if a feature is too thin for points strictly inside.
/// Deterministic. O(dots) per pass, times the logarithm of the number of the features' corners.
Result<std::vector<ClassDots>> distribute_dots(std::span<const MapFeature> features, const Box& box,
                                               const Density& density, const Options& options,
                                               const Control& control = {});

}  // namespace ccdt
