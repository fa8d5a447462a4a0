// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "api/decode/decode.h"
#include "api/halftone/halftone_request.h"
#include "api/output/json_writer.h"
#include "api/output/page.h"
#include "core/base/result.h"
#include "core/ccdt/plane/ccdt.h"
#include "core/density/density.h"
#include "core/halftone/dots/dots.h"
#include "core/halftone/field/field_plan.h"
#include "core/halftone/inks/print_proof.h"

namespace ccdt::api {

/// Number, size and density of the dots of each ink.
struct HalftonePlan {
    PictureSize picture;        ///< size of the drawn part of the picture, in pixels of the file
    std::vector<double> cover;  ///< [inks] share of the picture that the dots of each ink should cover
    /// Radius of the dots, in pixels of the picture. None: chosen for `cover` when the dots are drawn.
    std::optional<double> radius;
    /// Area that dots cover, divided by the area that they should cover. None if there are no dots, or if the choice of
    /// their number ignores overlaps.
    std::optional<double> tone;
    int samples = 0;                 ///< samples along each side of a pixel, as in DotOptions
    std::vector<std::size_t> sites;  ///< [inks] number of dots; for Dots::Both, one number for all inks
    std::vector<Density> densities;  ///< as `sites`; uniform if there are no dots
    std::optional<PrintProof>
        proof;  ///< simulated print for polishing several inks together; none if the polish does not need it
    std::optional<FieldPlan> field;  ///< only for Dots::Both
    Canvas canvas;
    Page page;
    std::vector<Warning> warnings;
    std::vector<std::vector<std::uint32_t>> paths;  ///< [inks] InkDots::path; none: no path has been searched

    /// Returns the size of the dots, for the answer; none if `tone` is none.
    std::optional<DotSize> size() const { return tone ? std::optional(DotSize{*radius, *tone}) : std::nullopt; }
    Box box() const { return {{0, 0}, {static_cast<double>(picture.width), static_cast<double>(picture.height)}}; }
};

/// Decodes the picture, separates it into inks, and distributes the sites among the inks. Errors: as for
/// run_halftone().
Result<HalftonePlan> plan_halftone(const HalftoneRequest& request, const Limits& limits, const Decode& decode,
                                   const Control& control);

/// Distributes the dots of each ink. Moves the densities out of the plan, and frees their memory at the end. Errors:
/// those of distribute_inks(), with the field of the image; Stopped, unless the request accepts a partial result.
/// @returns  as HalftonePlan::sites
Result<std::vector<Distribution>> place_dots(const HalftoneRequest& request, HalftonePlan& plan,
                                             const Control& control);

}  // namespace ccdt::api
