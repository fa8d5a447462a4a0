#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>

#include "api/input/colour.h"
#include "core/analysis/analysis.h"
#include "core/ccdt/ccdt.h"

namespace ccdt::api {

/// Pixels of a picture.
struct PictureSize {
    int width = 0;
    int height = 0;
};

/// What a JSON answer tells besides the points.
struct Report {
    std::uint64_t seed = 0;
    double elapsed_ms = 0;
    std::optional<PictureSize> picture;
    std::string_view method = "ccdt";
};

/// Writes the JSON answer of /sample and /halftone; also the mesh, if there is one, and that a run was stopped. Numbers
/// are the shortest that read back to the same double. Same input, same bytes. About 0.1 microseconds a number.
/// Stopped, it ends early, with nothing of use. Like all writers of JSON it throws std::domain_error for a number that
/// is not finite, which would be our own fault.
std::string write_distribution(const Distribution& distribution, const Report& report,
                               const std::stop_token& stop = {});

/// What a JSON answer tells of an ink.
struct InkReport {
    std::string_view name;
    Colour color;
    const Distribution& distribution;
};

/// Writes the JSON answer of /halftone in colour: the same, with points and what is told of their run ink by ink.
std::string write_inks(std::span<const InkReport> inks, const Report& report, const std::stop_token& stop = {});

/// Writes points as GeoJSON (RFC 7946): a Feature whose geometry is a MultiPoint, with what the report tells, but for
/// times, among its properties. Stopped, it ends early, with nothing of use.
std::string write_feature(const Distribution& distribution, const Report& report, const std::stop_token& stop = {});

/// Writes the JSON answer of /analyze, the spectrum only if it is asked for. Same input, same bytes.
std::string write_analysis(const Analysis& analysis, bool with_spectrum);

}  // namespace ccdt::api
