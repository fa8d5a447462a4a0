// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/analyze/surface_analyze.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <utility>

#include "api/analyze/point_file_reader.h"
#include "api/input/negotiation.h"
#include "api/input/option_reader.h"
#include "api/output/json_pieces.h"
#include "api/output/stage_costs.h"
#include "api/run/estimate.h"
#include "api/run/stopwatch.h"
#include "core/points/analysis/surface_analysis.h"

namespace ccdt::api {
namespace {

constexpr const FileFormat* kFormats[] = {&kJson};

Result<void> read_points(const Input& input, const Limits& limits, SurfaceAnalyzeRequest& request) {
    const auto text = read_text(input);
    if (!text) return tl::unexpected(text.error());
    return assign(request.points, read_point_file3(*text, limits).map_error([&](Error error) {
        return error_in_text(std::move(error), input);
    }));
}

constexpr std::array<OptionRule<SurfaceAnalyzeRequest>, 3> kRules = {{
    {"points", [](const Input& i, const Limits& l, SurfaceAnalyzeRequest& r) { return read_points(i, l, r); }},
    {"modes", [](const Input& i, const Limits&,
                 SurfaceAnalyzeRequest& r) { return assign(r.modes, read_integer(i, 1, kMaxModes)); }},
    {"format", [](const Input& i, const Limits&,
                  SurfaceAnalyzeRequest&) { return read_format(i, kFormats).map([](std::size_t) {}); }},
}};

std::string write(const SurfaceAnalysis& analysis) {
    std::string out = "{\"eigenvalues\":";
    append_numbers(out, analysis.eigenvalues);
    out += ",\"frequency\":";
    append_numbers(out, analysis.frequency);
    out += ",\"power\":";
    append_numbers(out, analysis.power);
    append_member(out, "min_distance", analysis.min_distance);
    append_member(out, "mean_distance", analysis.mean_distance);
    append_low_frequency_power(out, analysis.low_frequency_power);
    out += "}\n";
    return out;
}

}  // namespace

Result<SurfaceAnalyzeRequest> parse_surface_analyze(Result<SurfaceFile> file, const std::vector<TextOption>& options,
                                                    std::string_view accept, const Limits& limits) {
    SurfaceAnalyzeRequest request;
    ErrorList errors;
    errors.add(read_options<SurfaceAnalyzeRequest>(kRules, inputs_of(options), "points", limits, request));
    if (errors.result()) errors.add(check_surface_analysis(request.points.size(), request.modes));
    errors.add(file);
    if (std::ranges::find(options, "format", &TextOption::name) == options.end())
        errors.add(negotiate(accept, kFormats));
    if (auto right = errors.result(); !right) return tl::unexpected(right.error());
    request.file = *std::move(file);
    return request;
}

Result<Answer> run_surface_analyze(const SurfaceAnalyzeRequest& request, const Decode& decode, const Control& control,
                                   Timings& timings) {
    Stopwatch watch;
    auto read = decode.surface(request.file.bytes, request.file.header, control.stop);
    timings.decode = watch.lap();
    if (!read) return tl::unexpected(std::move(read.error()));
    const auto made = Surface::create(read->soup, std::nullopt, control.stop);
    if (!made) return tl::unexpected(made.error());
    const Surface& surface = made->surface;
    timings.prepare = watch.lap();
    std::vector<SurfacePoint> points;
    for (const Point3& p : request.points) {
        if (control.stop.stop_requested()) break;
        points.push_back(surface.nearest(surface.from_input(p)));
    }
    const auto analysis = analyse_surface(surface, points, request.modes, control.stop);
    timings.optimise = watch.lap();
    if (!analysis) return tl::unexpected(analysis.error());
    return Answer{kJson.content_type(), write(*analysis)};
}

Cost cost_of(const SurfaceAnalyzeRequest& request) {
    // Measured peaks of resident memory and times, for surfaces of 3,000 to 50,000 vertices and 100 to 400 modes.
    constexpr Estimate kTriangle{1'500, 5 * kMicrosecond};  // the surface, its search tree, and its matrices
    constexpr Estimate kPoint{200, 13 * kMicrosecond};
    constexpr double kModeValue = 42;                     // bytes of a mode at a vertex, with the basis
    constexpr double kSolution = 0.4 * kMicrosecond;      // for a mode and a vertex
    constexpr double kOrthogonal = 0.006 * kMicrosecond;  // for two modes and a vertex
    const SurfaceHeader& header = request.file.header;
    const auto modes = static_cast<double>(request.modes);
    const auto triangles = static_cast<double>(header.max_triangles);
    // count_mode_vertices() divides a coarse mesh until it has 20 vertices per mode. The last division quadruples the
    // number of vertices.
    constexpr double kPerMode = 20;
    const double most = std::min(std::max(static_cast<double>(header.max_vertices), 4 * kPerMode * modes) * modes,
                                 static_cast<double>(kMaxModeValues));
    double faces = std::max(triangles, 1.0);
    double vertices = std::min(static_cast<double>(header.max_vertices), faces / 2 + 2);
    for (; vertices < kPerMode * modes; faces *= 4) vertices += 1.5 * faces;
    const double typical = std::min(vertices, static_cast<double>(kMaxModeValues) / modes);
    const Estimate finding{most * kModeValue, typical * modes * (kSolution + kOrthogonal * modes)};
    const Estimate read{static_cast<double>(header.decoder_bytes), 0};
    return total_cost(then(read, kTriangle * std::max(triangles, 8 * kPerMode * modes) + finding +
                                     kPoint * static_cast<double>(request.points.size())));
}

std::size_t size_of(const SurfaceAnalyzeRequest& request) {
    return request.points.size() * sizeof(Point3);
}

}  // namespace ccdt::api
