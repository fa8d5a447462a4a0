// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "api/halftone/halftone_request.h"
#include "api/image/image_codec.h"
#include "api/output/json_writer.h"
#include "core/ccdt/ccdt.h"
#include "core/density/density.h"
#include "core/halftone/dot_fit.h"
#include "core/halftone/dots.h"
#include "core/halftone/print_proof.h"
#include "core/halftone/two_sided.h"
#include "core/result.h"

namespace ccdt::api {

/// Number, size and density of the dots of each ink.
struct HalftonePlan {
    PictureSize picture;
    std::vector<double> cover;     ///< [inks] share of the picture that the dots of each ink should cover
    std::optional<double> radius;  ///< radius of the dots, in pixels of the picture; none: chosen later, from `cover`
    /// Area that dots cover over the area that they should cover; none: unknown, or 1 because of `radius`.
    std::optional<double> tone;
    int samples = 0;                 ///< as in DotOptions
    std::vector<std::size_t> sites;  ///< [inks]; for dots on both sides [kinds]
    std::vector<Density> densities;  ///< density of the dots of each ink or kind; uniform if there are none
    std::optional<PrintProof>
        proof;  ///< target for the appearance of all inks together; only if several inks are polished
    std::optional<TwoSidedPlan> two_sides;  ///< only for dots on both sides of the tonal scale
    Canvas canvas;                          ///< canvas of a drawn answer
    std::vector<Warning> warnings;          ///< about the request

    /// Returns the size of the dots, for the answer; none if `tone` is unknown.
    std::optional<DotSize> size() const { return tone ? std::optional(DotSize{*radius, *tone}) : std::nullopt; }
    Box box() const { return {{0, 0}, {static_cast<double>(picture.width), static_cast<double>(picture.height)}}; }
};

/// Decodes the picture, separates it into inks, and distributes the sites among the inks.
Result<HalftonePlan> plan_halftone(const HalftoneRequest& request, const Limits& limits, const Decode& decode,
                                   const Control& control);

/// Dots after placement. Kinds are those of TwoSidedPlan: the dots of a kind flip the same channels.
struct PlacedDots {
    std::vector<Distribution> inks;  ///< [inks]; for dots on both sides [kinds]
    /// [kinds] sizes of dots on both sides, empty otherwise; radii in pixels of the picture. The bits of `white` are
    /// set where the ground has no ink or, if inks add, no light.
    std::vector<SizedDots> sized;
};

/// Distributes the dots of each ink. Moves the densities out of the plan, and frees their memory at the end.
Result<PlacedDots> place_dots(const HalftoneRequest& request, HalftonePlan& plan, const Control& control);

}  // namespace ccdt::api
