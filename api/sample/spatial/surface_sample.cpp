// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/spatial/surface_sample.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "api/input/option_reader.h"
#include "api/json/json_document.h"
#include "api/output/stage_costs.h"
#include "api/run/estimate.h"
#include "api/run/stopwatch.h"
#include "api/sample/spatial/voxel_input.h"
#include "api/surface/obj.h"
#include "api/text/numbers.h"
#include "api/text/text.h"
#include "core/ccdt/surface/surface_density.h"
#include "core/points/order/progressive_order.h"

namespace ccdt::api {
namespace {

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
    auto values = parse_list(input).and_then([&](const JsonDocument& document) {
        return read_densities({input.name, input.field, document.root()});
    });
    if (values && std::ranges::count(*values, 0) == std::ranges::ssize(*values))
        return failure(ErrorCode::Unusable, input.name + " must have a number above 0", input.field);
    return assign(request.density, std::move(values));
}

/// Checks the option `domain`. Its value `solid` requests points in space, which has another parser.
Result<void> check_domain(const Input& input) {
    static constexpr std::string_view kDomains[] = {"surface", "solid"};
    return read_word(input, kDomains).map([](std::size_t) {});
}

using Request = SurfaceRequest;

constexpr auto kRules = with_shared_rules(std::array<OptionRule<Request>, 6>{{
    {"domain", [](const Input& i, const Limits&, Request&) { return check_domain(i); }},
    {"iterations", [](const Input& i, const Limits&, Request& r) { return read_iterations(i, r.run); }},
    {"passes", [](const Input& i, const Limits&, Request& r) { return read_passes(i, r.run); }},
    {"quality", [](const Input& i, const Limits&, Request& r) { return read_quality_without_stealthy(i, r.run); }},
    {"density", [](const Input& i, const Limits&, Request& r) { return read_density(i, r); }},
    {"format",
     [](const Input& i, const Limits&, Request& r) { return assign(r.format, read_format(i, surface_formats())); }},
}});

/// Returns the error of a mesh without colours.
/// @param reason  why a picture could not be read; empty if all were read
tl::unexpected<Error> no_colours(const SurfaceFile& file, std::string reason) {
    if (file.header.format == SurfaceFormat::Obj) {
        if (const std::string_view name = materials_of_obj(file.bytes); !name.empty())
            reason = "its materials are in another file (" + excerpt(name) + "); send a GLB, which holds its textures";
    }
    return failure(ErrorCode::Unusable, "the mesh has no colours" + (reason.empty() ? reason : ": " + reason),
                   "density");
}

/// @param read  contents of the file, with valid colours
Result<SurfaceDensity> make_density(const SurfaceRequest& request, const Surface& surface, const SurfaceContents& read,
                                    const std::stop_token& stop) {
    const double spacing = std::sqrt(surface.total_area() / static_cast<double>(request.run.sites));
    if (const auto* values = std::get_if<std::vector<double>>(&request.density))
        return SurfaceDensity::of_vertices(surface, read.soup, *values);
    switch (std::get<SurfaceDensityKind>(request.density)) {
        case SurfaceDensityKind::Uniform:
            break;
        case SurfaceDensityKind::Colour:
            if (read.soup.colours.empty() && (!read.picture_error.empty() || read.soup.materials.empty()))
                return no_colours(request.file, read.picture_error);
            return SurfaceDensity::of_colours(surface, read.soup, spacing, stop);
        case SurfaceDensityKind::Curvature:
            return SurfaceDensity::of_curvature(surface, spacing, SurfaceDensity::kContrast, stop);
    }
    return SurfaceDensity::uniform();
}

/// Removes all colours or texture coordinates if some of them are invalid, and adds a warning.
void drop_invalid(TriangleSoup& soup, std::vector<SurfaceNote>& warnings) {
    const auto all = [](const auto& rows, auto is_valid) {
        return std::ranges::all_of(rows, [&](const auto& row) { return std::ranges::all_of(row, is_valid); });
    };
    if (!all(soup.colours, [](float light) { return light >= 0 && light <= 1; })) {
        soup.colours.clear();
        warnings.push_back({"the colours are ignored, because some are not numbers from 0 to 1"});
    }
    if (!all(soup.texture, [](float ordinate) { return std::isfinite(ordinate); })) {
        soup.texture.clear();
        warnings.push_back({"the texture coordinates are ignored, because some are not finite"});
    }
}

/// Adds a warning if an STL cannot tell vertices apart, because it has 32-bit floats.
void warn_of_rounding(const SurfaceRequest& request, const Surface& surface, std::vector<SurfaceNote>& warnings) {
    if (request.format->file.name != std::string_view("stl")) return;
    const Point3 corner = surface.to_input({0, 0, 0});
    const double rounding = 0x1p-24 * std::max({std::abs(corner.x), std::abs(corner.y), std::abs(corner.z)});
    constexpr double kMax = 1e-6;  // relative to the size of the mesh
    if (rounding <= kMax * surface.scale()) return;
    std::string detail = "STL has 32-bit floats, which round these coordinates by up to ";
    append_shortest(detail, static_cast<float>(rounding));
    warnings.push_back({detail + "; PLY, OBJ and GLB keep them"});
}

/// Puts points into the requested order. After a stop, the order is arbitrary.
void order_points(const SurfaceRequest& request, const Surface& surface, const SurfaceDensity& density,
                  const Control& control, SurfaceDistribution& dots) {
    if (request.order != PointOrder::Progressive) return;
    std::vector<Point3> positions, normals;
    for (const SurfacePoint& point : dots.points) {
        positions.push_back(surface.position(point));
        normals.push_back(surface.smooth_normal(point));
    }
    const bool uniform = density.is_uniform() && request.run.fixed.empty();
    set_order(dots,
              progressive_order_on_surface(positions, normals, surface.total_area(), uniform,
                                           surface.border_edges() == 0, control.stop, *control.executor),
              control.stop);
}

}  // namespace

std::vector<std::string_view> surface_options() {
    return names_of<Request>(kRules);
}

Result<SurfaceRequest> parse_surface(Result<SurfaceFile> file, const std::vector<TextOption>& options,
                                     std::string_view accept, const Limits& limits) {
    SurfaceRequest request;
    ErrorList errors;
    errors.add(read_options<Request>(kRules, inputs_of(options), "sites", limits, request));
    errors.add(file);
    if (auto right = errors.result(); !right) return tl::unexpected(right.error());
    request.file = *std::move(file);
    if (auto settled = settle_format(accept, request); !settled) return tl::unexpected(settled.error());
    return request;
}

Result<PlacedSurface> place_sample3(const SurfaceRequest& request, const Decode& decode, const Control& control,
                                    Timings& timings) {
    Stopwatch watch;
    auto read = decode.surface(request.file.bytes, request.file.header, control.stop);
    timings.decode = watch.lap();
    if (!read) return tl::unexpected(std::move(read.error()));
    auto made = Surface::create(read->soup, request.crease, control.stop);
    if (!made) return tl::unexpected(std::move(made.error()));
    drop_invalid(read->soup, made->warnings);
    const auto density = make_density(request, made->surface, *read, control.stop);
    if (!density) return tl::unexpected(density.error());
    if (!read->picture_error.empty()) made->warnings.push_back({read->picture_error});
    timings.prepare = watch.lap();
    auto dots = distribute_on_surface(made->surface, *density, request.run, control);
    if (dots) order_points(request, made->surface, *density, control, *dots);
    timings.optimise = watch.lap();
    if (!dots) return tl::unexpected(std::move(dots.error()));
    if (auto whole = check_whole(dots->stopped, request.on_deadline); !whole) return tl::unexpected(whole.error());
    warn_of_rounding(request, made->surface, made->warnings);
    for (std::string& warning : read->warnings) made->warnings.push_back({std::move(warning)});
    return PlacedSurface{std::move(read->soup),     std::move(made->surface), std::move(made->repairs),
                         std::move(made->warnings), *std::move(dots),         request.run.seed,
                         timings.before_encoding()};
}

Cost cost_of(const SurfaceRequest& request) {
    // Fitted to measured peaks of resident memory and to measured times; tests/api/cost_test.cpp compares the peaks.
    constexpr Estimate kTriangle{330, 3.2 * kMicrosecond}, kVertex{60, 0};
    constexpr Estimate kTexel{4, 0.02 * kMicrosecond};
    constexpr Estimate kTree{250, kMicrosecond};           // of a triangle, to place fixed points
    constexpr Estimate kProjection{0, 10 * kMicrosecond};  // of a fixed point near the surface
    constexpr Estimate kSite{600, 2 * kMicrosecond};       // initial sites and their triangulation
    constexpr Estimate kPass{0, 0.45 * kMicrosecond};      // pass of an iteration, of a site
    // Standard quality, of a site, for bodies about as thick as the spacing of the sites, which need more memory than
    // thicker ones. Much thinner bodies, such as ribbons, need twice as much, but the thickness is not known before the
    // mesh is read.
    constexpr Estimate kPolish{1'100, 17 * kMicrosecond};
    constexpr Estimate kPicture{1'500, 20 * kMicrosecond};                     // density by pictures, of a site
    constexpr Estimate kProgressive{100, 4 * kMicrosecond}, kKeptMesh{80, 0};  // of a site
    constexpr double kBest = 4;  // polish of the best quality, relative to the standard quality
    const SurfaceOptions& run = request.run;
    const SurfaceHeader& header = request.file.header;
    Estimate triangle = kTriangle, site = kSite + kPass * (static_cast<double>(run.iterations) * run.passes);
    if (!run.fixed.empty()) triangle = triangle + kTree;
    if (run.quality != Quality::Draft && run.iterations > 0)
        site = site + Estimate{kPolish.bytes, kPolish.seconds * (run.quality == Quality::Best ? kBest : 1)};
    if (run.keep_mesh) site = site + kKeptMesh;
    if (request.order == PointOrder::Progressive) site = site + kProgressive;
    const auto* kind = std::get_if<SurfaceDensityKind>(&request.density);
    if (kind != nullptr && *kind == SurfaceDensityKind::Colour && header.texels > 0) site = site + kPicture;
    const Estimate read{static_cast<double>(header.decoder_bytes), 0};
    const Estimate surface = triangle * static_cast<double>(header.max_triangles) +
                             kVertex * static_cast<double>(header.max_vertices) +
                             kTexel * static_cast<double>(header.texels);
    const Estimate points = site * static_cast<double>(run.sites + run.fixed.size()) +
                            kProjection * static_cast<double>(run.fixed.size()) +
                            request.format->per_site * static_cast<double>(run.sites);
    Cost cost = total_cost(then(read, surface + points));
    cost.answer = run.sites * request.format->least;
    return cost;
}

std::size_t size_of(const SurfaceRequest& request) {
    const auto* values = std::get_if<std::vector<double>>(&request.density);
    return request.run.fixed.size() * sizeof(Point3) + (values == nullptr ? 0 : values->size() * sizeof(double));
}

}  // namespace ccdt::api
