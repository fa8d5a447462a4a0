// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string_view>

#include "api/analyze.h"
#include "api/halftone.h"
#include "api/run/options.h"
#include "api/sample.h"

namespace ccdt::api {

/// Estimates the cost of computing an answer, before computing begins.
///
/// Returns an estimate for any parsed request, even if its domain or picture will be rejected. The model is fitted to
/// peaks of resident memory and to times of the whole program; tests/api/cost_test.cpp compares it with them. It
/// depends on the numbers of sites, pixels, inks and corners, and on the method, its iterations and passes. If a
/// halftone leaves sites or scale to the picture, the estimate is the largest for any picture of its size.
Cost cost_of(const HalftoneRequest& request, const Limits& limits);

/// Chooses the number of sites if a request leaves it to the picture: default_sites(), or sites_of_drawing() for
/// screens. If more than 4,096, it is at most the number that can be placed in two seconds.
///
/// @param part           size of the drawn part of the picture
/// @param ink, fineness  as for default_sites()
std::size_t usual_sites(const HalftoneRequest& request, PictureSize part, double ink, double fineness,
                        const Limits& limits);

Cost cost_of(const SampleRequest& request, const Limits& limits);
Cost cost_of(const AnalyzeRequest& request);

/// Estimates the cost of reading a JSON body, as parse_sample() does.
Cost cost_of_parsing(std::string_view body);

/// Counts the bytes that a request holds, without the body from which it was read.
std::size_t size_of(const HalftoneRequest& request);
std::size_t size_of(const SampleRequest& request);
std::size_t size_of(const AnalyzeRequest& request);

}  // namespace ccdt::api
