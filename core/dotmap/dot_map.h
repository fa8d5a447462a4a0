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

/// A part of a map, with a count of its own of the dots of each class.
struct MapFeature {
    Domain area;                    ///< no torus
    std::vector<std::size_t> dots;  ///< [classes]
};

/// The dots of a class.
struct ClassDots {
    Distribution dots;                      ///< no mesh; points by features, in the features' order
    std::vector<std::uint32_t> feature_of;  ///< [points]
};

/// Distributes as many dots in each feature as it counts, evenly, also across the features' borders: no dot leaves its
/// feature, and neighbours in two features keep a distance between that of both. Where features overlap there are the
/// dots of both. Dots of different classes are even each for themselves, and keep apart.
///
/// All dots of a class are the sites of one triangulation of all the ground that has some. A triangle aims at the area
/// that three discs would have which are as large as the ground of its corners' dots. Moves that would leave a feature
/// go along its border instead. Long waves of density error are evened out across borders where densities are alike,
/// and within each feature where they are not.
///
/// @param features  each of as many classes, with one dot in all at the least
/// @param box       that the density is stretched over
/// @param density   what ground of one feature wants, relative to other ground of the same
/// @param options   sites are those of the features, and a mesh is not kept
/// @param control   as distribute_inks() has it; a stop returns the dots as they stand, is no error, unless it comes
///                  during the start: Error Stopped
/// @returns         [classes]
/// Errors: as distribute(); Unusable with the field `features/i` if a density is zero all over a feature that has dots,
/// or a feature too thin for points strictly inside. Same input, same bytes. O(dots) per pass, with a logarithm of the
/// features' corners in front.
Result<std::vector<ClassDots>> distribute_dots(std::span<const MapFeature> features, const Box& box,
                                               const Density& density, const Options& options,
                                               const Control& control = {});

}  // namespace ccdt
