// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/surface_parser.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <utility>

#include "api/input/negotiation.h"
#include "api/input/option_reader.h"
#include "api/input/point_reader.h"
#include "api/input/run_options.h"
#include "api/json/json_document.h"
#include "api/sample/voxel_input.h"
#include "api/text/text.h"
#include "core/ccdt/ccdt.h"

namespace ccdt::api {
namespace {

/// A request that is being parsed. Its options have been read, but their combination has not been checked yet.
struct Draft {
    SurfaceRequest request;
    Options run;
};

Result<void> read_density(const Input& input, SurfaceRequest& request) {
    static constexpr Choice<SurfaceDensityKind> kWords[] = {{"uniform", SurfaceDensityKind::Uniform},
                                                            {"color", SurfaceDensityKind::Colour},
                                                            {"curvature", SurfaceDensityKind::Curvature}};
    const auto text = read_text(input);
    if (!text) return tl::unexpected(text.error());
    if (is_voxel_file(*text)) return malformed(input, "is a file of voxels, which needs domain=solid");
    if (!trim(*text, " \t\r\n").starts_with('['))
        return assign(request.density, read_choice<SurfaceDensityKind>(input, kWords).map_error([](Error error) {
            error.message += ", or a list in JSON with a number for each vertex";
            return error;
        }));
    const auto document = parse_list(input);
    if (!document) return tl::unexpected(document.error());
    std::vector<double> values;
    for (const JsonValue element : document->root()) {
        const std::string field = pointer_below(input.field, values.size());
        const auto value = read_number({field, field, element}, Interval{.min = 0});
        if (!value) return tl::unexpected(value.error());
        values.push_back(*value);
    }
    request.density = std::move(values);
    return {};
}

Result<void> read_crease(const Input& input, SurfaceRequest& request) {
    constexpr double kDegree = std::numbers::pi / 180;
    constexpr Interval kAngles{.min = 0, .max = 180, .above_min = true};
    return assign(request.crease, read_number(input, kAngles).map([](double degrees) { return degrees * kDegree; }));
}

/// Checks the option `domain`. Its value `solid` requests points in space, which has another parser.
Result<void> check_domain(const Input& input) {
    if (const auto text = read_text(input); text && *text == "surface") return {};
    return malformed(input, "must be surface or solid");
}

constexpr std::array<OptionRule<Draft>, 13> kRules = {{
    {"domain", [](const Input& i, const Limits&, Draft&) { return check_domain(i); }},
    {"sites", [](const Input& i, const Limits& l, Draft& d) { return assign(d.run.sites, read_sites(i, l)); }},
    {"seed", [](const Input& i, const Limits&, Draft& d) { return read_seed(i, d.run); }},
    {"iterations", [](const Input& i, const Limits&, Draft& d) { return read_iterations(i, d.run); }},
    {"passes", [](const Input& i, const Limits&, Draft& d) { return read_passes(i, d.run); }},
    {"quality", [](const Input& i, const Limits&, Draft& d) { return read_halftone_quality(i, d.run); }},
    {"on_deadline",
     [](const Input& i, const Limits&, Draft& d) { return assign(d.request.on_deadline, read_on_deadline(i)); }},
    {"density", [](const Input& i, const Limits&, Draft& d) { return read_density(i, d.request); }},
    {"crease", [](const Input& i, const Limits&, Draft& d) { return read_crease(i, d.request); }},
    {"fixed",
     [](const Input& i, const Limits& l, Draft& d) { return assign(d.request.run.fixed, read_space_points(i, l)); }},
    {"order", [](const Input& i, const Limits&, Draft& d) { return assign(d.request.order, read_space_order(i)); }},
    {"mesh", [](const Input& i, const Limits&, Draft& d) { return assign(d.run.keep_mesh, read_boolean(i)); }},
    {"format", [](const Input& i, const Limits&,
                  Draft& d) { return assign(d.request.format, read_format(i, surface_formats())); }},
}};

}  // namespace

std::vector<std::string_view> surface_options() {
    return names_of<Draft>(kRules);
}

Result<SurfaceRequest> parse_surface(Result<SurfaceFile> file, const std::vector<TextOption>& options,
                                     std::string_view accept, const Limits& limits) {
    Draft draft;
    ErrorList errors;
    const auto has_sites = std::ranges::find(options, "sites", &TextOption::name) != options.end();
    errors.add(read_options<Draft>(kRules, inputs_of(options), limits, draft));
    if (!has_sites) errors.add(Result<void>(failure(ErrorCode::Malformed, "sites is missing", "sites")));
    errors.add(file);
    if (auto right = errors.result(); !right) return tl::unexpected(right.error());
    auto& [request, run] = draft;
    SurfaceOptions& chosen = request.run;
    chosen.sites = run.sites;
    chosen.seed = run.seed;
    chosen.iterations = run.iterations;
    chosen.passes = run.passes;
    chosen.quality = run.quality;
    chosen.keep_mesh = run.keep_mesh;
    request.file = *std::move(file);
    auto settled = settle_format(accept, surface_formats(), request.format);
    if (settled) settled = check_mesh(*request.format, chosen.keep_mesh);
    if (!settled) return tl::unexpected(settled.error());
    return std::move(request);
}

}  // namespace ccdt::api
