#pragma once

#include <cstdint>
#include <span>

#include "core/ccdt/ccdt.h"

namespace ccdt {

/// Puts the points of a distribution into an order, and those of its mesh, if there is one, with them.
/// @param order  indices [points]: a permutation
void reorder(Distribution& distribution, std::span<const std::uint32_t> order);

}  // namespace ccdt
