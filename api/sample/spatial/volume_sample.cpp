// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/spatial/volume_sample.h"

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <utility>

#include "api/decode/timed_decode.h"
#include "api/input/domain_reader.h"
#include "api/input/option_reader.h"
#include "api/input/polygon_reader.h"
#include "api/output/stage_costs.h"
#include "api/run/stopwatch.h"
#include "api/text/text.h"
#include "core/base/elementary.h"
#include "core/ccdt/volume/distribute_solid.h"
#include "core/ccdt/volume/solid.h"
#include "core/points/order/progressive_order.h"

namespace ccdt::api {
namespace {

/// Values of the option `domain` that are words.
enum class DomainWord { Box, Torus, Solid };

/// A request that is being parsed. Its options have been read, but their combination has not been checked yet.
struct Draft : VolumeRequest {
    DomainWord word = DomainWord::Box;
    bool is_object = false;  ///< whether the domain was given with its sides
    Point3 sides;            ///< sides given by options; 0: not given
};

Result<void> read_domain(const Input& input, Draft& draft) {
    static constexpr Choice<DomainWord> kWords[] = {
        {"box", DomainWord::Box}, {"torus", DomainWord::Torus}, {"solid", DomainWord::Solid}};
    const auto text = read_text(input);
    if (text && (draft.is_json || !trim(*text).starts_with('{')))
        return assign(draft.word, read_choice<DomainWord>(input, kWords).map_error([](Error error) {
            error.message += ", or an object in JSON";
            return error;
        }));
    draft.is_object = true;
    if (!text) return assign(draft.domain, read_box(input));
    return assign(draft.domain, parse_json(input).and_then([](const JsonDocument& document) {
        return read_box({"/domain", "/domain", document.root()});
    }));
}

template <double Point3::*kSide>
Result<void> read_side(const Input& input, const Limits&, Draft& draft) {
    return assign(draft.sides.*kSide, read_number(input, kPositive));
}

/// The first rule, for crease, is only for solids. The last three are for the sides of a domain that is given as a
/// word.
constexpr auto kRules = with_shared_rules(std::array<OptionRule<Draft>, 7>{{
    {"domain", [](const Input& i, const Limits&, Draft& d) { return read_domain(i, d); }},
    {"density", [](const Input& i, const Limits& l, Draft& d) { return assign(d.density, read_voxels(i, l)); }},
    {"quality", [](const Input& i, const Limits&, Draft& d) { return read_quality(i, d.run); }},
    {"format",
     [](const Input& i, const Limits&, Draft& d) { return assign(d.format, read_format(i, volume_formats())); }},
    {"width", read_side<&Point3::x>},
    {"height", read_side<&Point3::y>},
    {"depth", read_side<&Point3::z>},
}});

tl::unexpected<Error> wrong(std::string_view option, std::string_view what) {
    return failure(ErrorCode::Malformed, std::string(option).append(" ").append(what), std::string(option));
}

/// Determines the sides of a domain that is given as a word.
Result<void> settle_domain(Draft& draft) {
    const auto& [width, height, depth] = draft.sides;
    const bool any_side = width > 0 || height > 0 || depth > 0;
    if (any_side && draft.solid) return wrong("domain", "solid allows no width, height or depth");
    if (any_side && draft.is_object)
        return wrong("domain", "must be the word box or torus if width, height or depth is an option");
    if (!draft.solid && draft.word == DomainWord::Solid) return wrong("domain", "solid needs a mesh");
    if (draft.is_object || draft.solid) return {};
    const auto side_or = [&](double given, std::size_t axis) {
        return given > 0 ? given : static_cast<double>(draft.density.voxels[axis]);
    };
    draft.domain = {{side_or(width, 0), side_or(height, 1), side_or(depth, 2)}, draft.word == DomainWord::Torus};
    const Point3& sides = draft.domain.sides;
    if (sides.x > 0 && sides.y > 0 && sides.z > 0) return {};
    return wrong("domain",
                 std::string(draft.domain.periodic ? "torus" : "box") + " needs the options width, height and depth");
}

/// Checks that the quality is available for a density that may not be uniform.
Result<void> check_quality_for_density(const VolumeRequest& request, bool is_uniform) {
    if (is_uniform || request.run.quality != Quality::Stealthy) return {};
    return wrong("quality", "stealthy needs a uniform density");
}

Result<void> check_quality(const VolumeRequest& request) {
    if (request.run.quality != Quality::Stealthy) return {};
    if (request.solid || !request.domain.periodic) return wrong("quality", "stealthy needs a domain of the type torus");
    if (!request.run.fixed.empty()) return wrong("quality", "stealthy allows no fixed points");
    if (auto checked = check_quality_for_density(request, request.density.is_uniform.value_or(true)); !checked)
        return checked;
    constexpr double kMin = 16;  // sites in a cube; with fewer, power above -100 dB may remain
    const auto& [x, y, z] = request.domain.sides;
    const double side = std::min({x, y, z});
    if (static_cast<double>(request.run.sites) >= kMin * (x / side) * (y / side) * (z / side)) return {};
    return wrong("quality", "stealthy needs at least 16 sites for each cube with the shortest side of the torus");
}

Result<void> check(Draft& draft, std::string_view accept) {
    ErrorList errors;
    const auto settled = settle_domain(draft);
    errors.add(settled);
    if (settled) {
        errors.add(draft.solid ? check_sites(draft.run) : check_volume(draft.domain, draft.run));
        errors.add(check_quality(draft));
    }
    errors.add(settle_format(accept, draft));
    return errors.result();
}

/// Reads options and checks their combination.
/// @param draft  contains the body, if it is not JSON
Result<VolumeRequest> parse(Draft draft, std::span<const Input> inputs, std::string_view accept, const Limits& limits) {
    const auto rules = std::span(kRules).subspan(draft.solid ? 0 : 1);
    const auto checked =
        read_options<Draft>(rules, inputs, "sites", limits, draft).and_then([&] { return check(draft, accept); });
    if (!checked) return tl::unexpected(draft.located(checked.error()));
    return draft;
}

/// Reads the mesh that bounds a solid.
/// @param placed  receives the notes about the mesh
Result<Solid> make_solid(const VolumeRequest& request, const Decode& decode, const std::stop_token& stop,
                         PlacedVolume& placed) {
    auto read = decode.surface(request.solid->bytes, request.solid->header, stop);
    if (!read) return tl::unexpected(read.error());
    auto made = Surface::create(read->soup, request.crease.value_or(Solid::kCrease), stop);
    if (!made) return tl::unexpected(made.error());
    placed.repairs = std::move(made->repairs);
    placed.warnings = std::move(made->warnings);
    for (std::string& warning : read->warnings) placed.warnings.push_back({std::move(warning)});
    return Solid::create(std::move(made->surface), stop);
}

/// Puts points into the requested order. After a stop, the order is arbitrary.
/// @param solid  null: the domain is a box or torus
void order_points(const VolumeRequest& request, const Solid* solid, const VoxelDensity& density, const Control& control,
                  VolumeDistribution& dots) {
    if (request.order != PointOrder::Progressive) return;
    const auto& [sides, periodic] = request.domain;
    const bool uniform = density.is_uniform() && request.run.fixed.empty();
    const Box3 box = solid == nullptr ? Box3{{}, sides} : solid->bounds();
    const double share = solid == nullptr ? 1 : std::min(1.0, solid->share());
    set_order(dots,
              progressive_order_in_space(box, solid == nullptr && periodic, dots.points, share, uniform, control.stop,
                                         *control.executor),
              control.stop);
}

/// Estimates the number of points and of copies of them within two spacings of the domain, for each site. Thin domains
/// are as thick as a spacing during the computation.
double copies_of(const VolumeRequest& request) {
    if (request.solid) return 1;
    constexpr double kRim = 4;  // on both sides together, in spacings
    const std::size_t points = request.run.sites + request.run.fixed.size();
    const Point3 sides = unit_sides(request.domain.sides, points);
    const double spacing = elementary::cbrt(sides.x * sides.y * sides.z / static_cast<double>(points));
    return (1 + kRim * spacing / sides.x) * (1 + kRim * spacing / sides.y) * (1 + kRim * spacing / sides.z);
}

}  // namespace

std::vector<std::string_view> volume_options() {
    return names_of<Draft>(kRules);
}

bool asks_for_volume(JsonValue root) {
    const auto domain = root.is_object() && !is_geojson(root) ? root.find("domain") : std::nullopt;
    if (!domain || !(domain->is_string() || is_box(*domain))) return false;
    const auto format = root.find("format");
    return !(format && format->is_string() && format->text().starts_with("mask"));
}

bool asks_for_solid(const std::vector<TextOption>& options) {
    return std::ranges::any_of(
        options, [](const TextOption& option) { return option.name == "domain" && option.value == "solid"; });
}

Result<VolumeRequest> parse_volume(JsonValue root, const std::vector<TextOption>& options, std::string_view accept,
                                   const Limits& limits) {
    if (!options.empty())
        return failure(ErrorCode::Malformed, "options must be members of the JSON body", excerpt(options.front().name));
    const auto inputs = inputs_of(root, "");
    if (!inputs) return tl::unexpected(inputs.error());
    Draft draft;
    draft.is_json = true;
    return parse(std::move(draft), *inputs, accept, limits);
}

Result<VolumeRequest> parse_volume(Result<VoxelInput> voxels, const std::vector<TextOption>& options,
                                   std::string_view accept, const Limits& limits) {
    if (!voxels) return tl::unexpected(voxels.error());
    if (std::ranges::find(options, "density", &TextOption::name) != options.end())
        return wrong("density", "is given twice, because the body has voxels");
    Draft draft;
    draft.density = *std::move(voxels);
    return parse(std::move(draft), inputs_of(options), accept, limits);
}

Result<VolumeRequest> parse_solid(Result<SurfaceFile> mesh, const std::vector<TextOption>& options,
                                  std::string_view accept, const Limits& limits) {
    if (!mesh) return tl::unexpected(mesh.error());
    Draft draft;
    draft.solid = *std::move(mesh);
    return parse(std::move(draft), inputs_of(options), accept, limits);
}

Result<PlacedVolume> place_sample3(const VolumeRequest& request, const Decode& decode, const Control& control,
                                   Timings& timings) {
    const auto located = [&](Error error) { return request.located(std::move(error)); };
    PlacedVolume placed{.dots = {}, .domain = request.domain, .quality = request.run.quality, .seed = request.run.seed};
    Stopwatch watch;
    const Decode timed_decode = timed(decode, timings.decode);
    const auto density = make_density(request.density, timed_decode, control.stop).map_error(located);
    if (!density) return tl::unexpected(density.error());
    if (auto checked = check_quality_for_density(request, density->is_uniform()).map_error(located); !checked)
        return tl::unexpected(checked.error());
    std::optional<Solid> solid;
    if (request.solid) {
        auto made = make_solid(request, timed_decode, control.stop, placed);
        if (!made) return tl::unexpected(std::move(made.error()));
        solid = *std::move(made);
    }
    timings.prepare = watch.lap() - timings.decode;
    auto dots = solid ? distribute_in_solid(*solid, *density, request.run, control)
                      : distribute_in_volume(request.domain, *density, request.run, control);
    if (dots) order_points(request, solid ? &*solid : nullptr, *density, control, *dots);
    timings.optimise = watch.lap();
    if (!dots) return tl::unexpected(located(std::move(dots.error())));
    if (auto whole = check_whole(dots->stopped, request.on_deadline); !whole) return tl::unexpected(whole.error());
    placed.dots = *std::move(dots);
    placed.elapsed = timings.before_encoding();
    return placed;
}

Cost cost_of(const VolumeRequest& request) {
    // Fitted to measured peaks of resident memory and to measured times; tests/api/cost_test.cpp compares the peaks.
    static_assert(static_cast<int>(Quality::Stealthy) == 3);
    constexpr std::array<Estimate, 4> kOfQuality = {{{100, 34 * kMicrosecond},  // draft
                                                     {260, 31 * kMicrosecond},
                                                     {300, 60 * kMicrosecond},
                                                     {550, 77 * kMicrosecond}}};  // stealthy
    constexpr Estimate kUneven{260, 65 * kMicrosecond}, kSolid{250, 65 * kMicrosecond};
    constexpr Estimate kMesh{750, 14 * kMicrosecond}, kSolidMesh{750, 120 * kMicrosecond},
        kProgressive{100, 7 * kMicrosecond};
    constexpr Estimate kTriangle{300, 3.2 * kMicrosecond};         // of a mesh, as for points on its surface
    constexpr double kInBlock = 750, kMaxInBlocks = 4.0 * 10'000;  // sites of blocks that are relaxed at a time
    constexpr Estimate kCopy{50, 12 * kMicrosecond};
    const VolumeOptions& run = request.run;
    Estimate site = kOfQuality[static_cast<std::size_t>(run.quality)];
    if (request.solid) {
        site = site + kSolid;
    } else if (!request.density.is_uniform.value_or(false)) {
        site = site + kUneven;
    }
    const double points_per_site = copies_of(request);
    site = site + kCopy * (points_per_site - 1);
    if (run.keep_mesh) site = site + (request.solid ? kSolidMesh : kMesh * points_per_site);
    if (request.order == PointOrder::Progressive) site = site + kProgressive;
    const auto count = static_cast<double>(run.sites + run.fixed.size());
    // The blocks of a thin domain have fewer sites than those of other domains, so that they have at most three times
    // as many points as a usual block has sites.
    const double in_block = kInBlock * std::max(1.6, points_per_site);
    const double in_blocks =
        std::min(in_block * count, kInBlock * kMaxInBlocks * std::clamp(points_per_site, 1.6, 3.0));
    const Estimate points =
        site * count + Estimate{in_blocks, 0} + request.format->per_site * static_cast<double>(run.sites);
    const SurfaceHeader mesh = request.solid ? request.solid->header : SurfaceHeader{};
    const Estimate read{static_cast<double>(mesh.decoder_bytes), 0};
    Cost cost = total_cost(
        then(read, voxel_cost(request.density) + kTriangle * static_cast<double>(mesh.max_triangles) + points));
    cost.answer = run.sites * request.format->least;
    return cost;
}

std::size_t size_of(const VolumeRequest& request) {
    return request.run.fixed.size() * sizeof(Point3) + bytes_of(request.density);
}

}  // namespace ccdt::api
