// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "api/input/palette.h"
#include "core/ccdt/plane/ccdt.h"
#include "core/geometry/point.h"

namespace ccdt::api {

/// The areas that inks cover in a drawing by one field, in the units of the points.
struct InkAreas {
    std::span<const Ink> inks;
    std::vector<std::vector<std::vector<Point>>> rings;  ///< [inks] rings around the ink, by the even-odd rule

    /// Returns whether answers name the inks. A single ink has no name; answers then contain only its rings.
    bool are_named() const { return !inks.front().name.empty(); }
};

/// Dots of an ink or of a class of a dot map, as writers receive them. All objects to which this object refers must
/// outlive it.
struct InkDots {
    const Ink& ink;  ///< name and colour of the ink or class; the name is empty if answers do not name it
    const Distribution& dots;
    double radius = 0;                ///< radius of each dot, in the units of the points; used only by drawings
    const InkAreas* areas = nullptr;  ///< what the sites of one field draw; null: the dots are discs
    /// [points] Index of each point's feature, in ascending order; empty if points are not grouped by features.
    std::span<const std::uint32_t> features = {};
    /// Order in which a pen draws the points, as PenRun::path; empty: a short path is searched.
    std::span<const std::uint32_t> path = {};
};

/// Returns the ranks of `count` points from the point `first` on; empty if the points have no ranks.
inline std::span<const std::uint32_t> ranks_of(const Distribution& points, std::size_t first, std::size_t count) {
    const std::span<const std::uint32_t> all = points.ranks;
    return all.empty() ? all : all.subspan(first, count);
}

}  // namespace ccdt::api
