// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "api/input/file_formats.h"
#include "api/json/json_document.h"
#include "api/output/body.h"
#include "api/run/deadline.h"
#include "api/run/options.h"
#include "core/base/result.h"
#include "core/ccdt/plane/ccdt.h"
#include "core/geometry/point3.h"
#include "core/points/choice/choice.h"

namespace ccdt::api {

struct ChoiceFormat;

/// Request to /sample with candidates: an exact number of given points.
struct ChoiceRequest {
    std::vector<Point3> candidates;  ///< as given; z is 0 in the plane
    choice::Extent extent = choice::Extent::Plane;
    bool is_on_globe = false;  ///< whether candidates are longitudes and latitudes
    std::size_t sites = 0;
    std::vector<double> density, priority;  ///< [candidates] or empty
    std::vector<std::uint8_t> kept;         ///< [candidates] or empty
    std::uint64_t seed = 0;
    const ChoiceFormat* format = nullptr;  ///< never null in a parsed request
    OnStop on_deadline = OnStop::Error;    ///< a partial answer is spread less evenly
};

/// Format of chosen candidates: a row of the table in choice_sample.cpp.
struct ChoiceFormat {
    FileFormat file;
    double bytes_per_site;  ///< memory of a chosen candidate in the answer
    void (*write)(const ChoiceRequest& request, const ChosenCandidates& chosen, bool partial, std::string& out);
};

/// Returns the formats, in the server's order of preference.
std::span<const ChoiceFormat* const> choice_formats();

/// Returns the names of the options.
std::vector<std::string_view> choice_options();

/// Whether a body of /sample has candidates.
bool asks_for_choice(JsonValue root);

/// Reads a request whose body has candidates.
/// @param options  options that are given as text; must be empty
/// Errors: Malformed for a value of the wrong type or out of range, and for lists of different lengths; LimitExceeded
/// for more than limits.max_sites candidates; Unusable if there are more sites than candidates; NotAcceptable.
Result<ChoiceRequest> parse_choice(JsonValue root, const std::vector<TextOption>& options, std::string_view accept,
                                   const Limits& limits);

/// Chooses candidates and writes them in the requested format. Errors: those of choose_points(); Stopped, unless the
/// request accepts a partial result. Same request, same bytes.
Result<Answer> run_choice(const ChoiceRequest& request, const Control& control, Timings& timings,
                          BodySink* sink = nullptr);

/// Estimates the cost of run_choice().
Cost cost_of(const ChoiceRequest& request);

/// Returns the size of a parsed request in bytes, without the body from which it was read.
std::size_t size_of(const ChoiceRequest& request);

}  // namespace ccdt::api
