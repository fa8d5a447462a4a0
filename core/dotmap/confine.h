#pragma once

#include <cstdint>
#include <span>
#include <stop_token>
#include <vector>

#include "core/dotmap/dot_map.h"
#include "core/geometry/domain.h"
#include "core/result.h"

namespace ccdt {

/// Takes from features what lies outside of a domain. Those of which nothing is left keep their area and lose their
/// dots.
///
/// @param kept  no torus
/// @returns     numbers of the features that lost dots
/// Errors: Stopped.
Result<std::vector<std::uint32_t>> confine(std::span<MapFeature> features, const Domain& kept,
                                           const std::stop_token& stop = {});

/// Counts the dots of a feature, of all classes.
std::size_t dots_of(const MapFeature& feature);

}  // namespace ccdt
