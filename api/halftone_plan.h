// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "api/halftone.h"
#include "api/image/image_codec.h"
#include "api/output/json_writer.h"
#include "core/ccdt/ccdt.h"
#include "core/density/density.h"
#include "core/halftone/dots.h"
#include "core/halftone/print_proof.h"
#include "core/halftone/two_sided.h"
#include "core/result.h"

namespace ccdt::api {

/// Share of each ink in the picture, and where its dots shall go.
struct HalftonePlan {
    PictureSize picture;
    std::vector<double> cover;        ///< [inks] mean share that dots cover
    std::optional<double> radius;     ///< of the dots, in pixels of the picture; none: such that they cover so much
    std::optional<double> tone;       ///< what they cover over what they should; none: unknown, or 1 by their radius
    int samples = 0;                  ///< as DotOptions
    std::vector<std::size_t> sites;   ///< [inks], or [kinds] of dots on both sides
    std::vector<Density> densities;   ///< [inks] or [kinds]; uniform for those without sites
    std::optional<PrintProof> proof;  ///< if there are several inks, of which all together are seen
    std::optional<TwoSidedPlan> two_sides;  ///< if dots are on both sides of the tonal scale
    Canvas canvas;                          ///< of an answer that is drawn
    std::vector<Warning> warnings;          ///< about the request

    /// What is told of the dots' size.
    std::optional<DotSize> size() const { return tone ? std::optional(DotSize{*radius, *tone}) : std::nullopt; }
    Box box() const { return {{0, 0}, {static_cast<double>(picture.width), static_cast<double>(picture.height)}}; }
};

/// Decodes, separates into inks, shares the sites among them.
/// Errors: those of run_halftone but for writing.
Result<HalftonePlan> plan_halftone(const HalftoneRequest& request, const Limits& limits, const Decode& decode,
                                   const Control& control);

/// Dots of each ink, where they lie.
struct PlacedDots {
    std::vector<Distribution> inks;  ///< [inks], or [kinds] of dots on both sides
    std::vector<SizedDots> sized;    ///< [kinds] if dots are on both sides; radii in pixels of the picture, and
                                     ///< as white ground counts what is not ink, or lamps that are off
};

/// Distributes the dots of each ink. The densities are taken, and given back as soon as the dots lie.
Result<PlacedDots> place_dots(const HalftoneRequest& request, HalftonePlan& plan, const Control& control);

}  // namespace ccdt::api
