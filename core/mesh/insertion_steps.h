// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace ccdt {

/// Lists all sites in steps, in the best order for their insertion. The sites are numbered along a space-filling curve.
/// The first steps have few sites far apart, which keeps the triangles round. Within a step, successive sites are close
/// together, which keeps the walks of point location short.
/// @param visit  called with the sites of each step, in ascending order; returns false to end the enumeration
/// @returns      false if `visit` ended the enumeration
template <class Visit>
bool for_insertion_steps(std::size_t sites, Visit&& visit) {
    std::vector<std::uint32_t> step;
    for (std::size_t stride = 64, coarser = 0; stride >= 1; coarser = stride, stride /= 4) {
        step.clear();
        for (std::size_t site = 0; site < sites; site += stride) {
            if (coarser == 0 || site % coarser != 0) step.push_back(static_cast<std::uint32_t>(site));
        }
        if (!visit(std::span<const std::uint32_t>(step))) return false;
    }
    return true;
}

}  // namespace ccdt
