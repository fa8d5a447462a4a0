#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/dotmap/dot_map.h"
#include "core/geometry/domain.h"
#include "core/result.h"

namespace ccdt {

/// What is left of an area. Errors: Unusable if that is nothing; others.
using Cut = std::function<Result<Domain>(const Domain& area)>;

/// Cuts the areas of all features that have dots. Those of which nothing is left keep their area and lose their dots.
/// @returns  numbers of the features that lost dots
/// Errors: those of the cut but Unusable.
Result<std::vector<std::uint32_t>> cut_areas(std::span<MapFeature> features, const Cut& cut);

/// Takes from features what lies outside of a domain, as cut_areas() does.
/// @param kept  no torus
/// Errors: Stopped.
Result<std::vector<std::uint32_t>> confine(std::span<MapFeature> features, const Domain& kept,
                                           const std::stop_token& stop = {});

/// Counts the dots of a feature, of all classes.
std::size_t dots_of(const MapFeature& feature);

}  // namespace ccdt
