#pragma once

#include <cstddef>
#include <string_view>

#include "api/analyze.h"
#include "api/halftone.h"
#include "api/run/options.h"
#include "api/sample.h"

namespace ccdt::api {

/// Estimates what computing an answer takes, before it is begun.
///
/// A number for any request that was parsed, also where its domain or its picture will be refused. Fitted to peaks of
/// resident memory and to times of the whole program; tests/api/cost_test.cpp holds them to it. What decides are sites,
/// pixels, inks, corners, the method, its iterations and passes. A halftone that leaves its sites or its scale to the
/// picture costs as much as any picture of its size can make it.
Cost cost_of(const HalftoneRequest& request, const Limits& limits);

/// Chooses the number of sites that a request leaves to its picture: default_sites(), or for the screen
/// sites_of_drawing(), but of more than 4,096 no more than are placed in two seconds.
///
/// @param part           of the picture that is drawn
/// @param ink, fineness  as default_sites() has them
std::size_t usual_sites(const HalftoneRequest& request, PictureSize part, double ink, double fineness,
                        const Limits& limits);

Cost cost_of(const SampleRequest& request, const Limits& limits);
Cost cost_of(const AnalyzeRequest& request);

/// Estimates what reading a JSON body takes: parse_sample and the like.
Cost cost_of_parsing(std::string_view body);

/// Counts the bytes that a request holds besides the body that it was read from.
std::size_t size_of(const HalftoneRequest& request);
std::size_t size_of(const SampleRequest& request);
std::size_t size_of(const AnalyzeRequest& request);

}  // namespace ccdt::api
