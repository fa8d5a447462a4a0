// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/base/result.h"
#include "core/ccdt/maps/map_feature.h"
#include "core/geometry/domain.h"

namespace ccdt {

/// Function that returns the rest of an area after a cut. Returns the error Unusable only if nothing remains.
using Cut = std::function<Result<Domain>(const Domain& area)>;

/// Cuts the areas of all features that have dots. If a cut would remove all of a feature's area, the feature's dots are
/// removed instead, and its area does not change.
/// @returns  numbers of the features that lost their dots
///
/// Errors: those of `cut` except Unusable.
Result<std::vector<std::uint32_t>> cut_areas(std::span<MapFeature> features, const Cut& cut);

/// Removes the parts of features that lie outside a domain. Features that would vanish are treated as in cut_areas().
/// @param kept  not a torus
///
/// Errors: Stopped.
Result<std::vector<std::uint32_t>> confine(std::span<MapFeature> features, const Domain& kept,
                                           const std::stop_token& stop = {});

/// Returns the number of dots of a feature, over all classes.
std::size_t dots_of(const MapFeature& feature);

}  // namespace ccdt
