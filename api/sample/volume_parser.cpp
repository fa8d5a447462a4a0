// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/volume_parser.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <variant>

#include "api/input/domain_reader.h"
#include "api/input/negotiation.h"
#include "api/input/option_reader.h"
#include "api/input/point_reader.h"
#include "api/input/run_options.h"
#include "core/ccdt/ccdt.h"

namespace ccdt::api {
namespace {

/// Values of the option `domain` that are words.
enum class DomainWord { Box, Torus, Solid };

/// A request that is being parsed. Its options have been read, but their combination has not been checked yet.
struct Draft {
    VolumeRequest request;
    Options run;
    DomainWord word = DomainWord::Box;
    bool is_object = false;  ///< whether the domain was given with its sides
    Point3 sides;            ///< sides given by options; 0: not given
};

Result<void> read_domain(const Input& input, Draft& draft) {
    static constexpr Choice<DomainWord> kWords[] = {
        {"box", DomainWord::Box}, {"torus", DomainWord::Torus}, {"solid", DomainWord::Solid}};
    const auto* text = std::get_if<std::string_view>(&input.value);
    if (text != nullptr && !text->starts_with('{')) return assign(draft.word, read_choice<DomainWord>(input, kWords));
    draft.is_object = true;
    if (text == nullptr) return assign(draft.request.domain, read_box(input));
    const auto document = JsonDocument::parse(*text);
    if (!document) return malformed(input, "must be valid JSON: " + document.error().message);
    return assign(draft.request.domain, read_box({"/domain", "/domain", document->root()}));
}

template <double Point3::*kSide>
Result<void> read_side(const Input& input, const Limits&, Draft& draft) {
    return assign(draft.sides.*kSide, read_number(input, kPositive));
}

constexpr std::array<OptionRule<Draft>, 13> kRules = {{
    {"domain", [](const Input& i, const Limits&, Draft& d) { return read_domain(i, d); }},
    {"density", [](const Input& i, const Limits& l, Draft& d) { return assign(d.request.density, read_voxels(i, l)); }},
    {"sites", [](const Input& i, const Limits& l, Draft& d) { return assign(d.run.sites, read_sites(i, l)); }},
    {"seed", [](const Input& i, const Limits&, Draft& d) { return read_seed(i, d.run); }},
    {"quality", [](const Input& i, const Limits&, Draft& d) { return read_quality(i, d.run); }},
    {"on_deadline",
     [](const Input& i, const Limits&, Draft& d) { return assign(d.request.on_deadline, read_on_deadline(i)); }},
    {"fixed",
     [](const Input& i, const Limits& l, Draft& d) { return assign(d.request.run.fixed, read_space_points(i, l)); }},
    {"order", [](const Input& i, const Limits&, Draft& d) { return assign(d.request.order, read_space_order(i)); }},
    {"mesh", [](const Input& i, const Limits&, Draft& d) { return assign(d.run.keep_mesh, read_boolean(i)); }},
    {"format", [](const Input& i, const Limits&,
                  Draft& d) { return assign(d.request.format, read_format(i, volume_formats())); }},
    // The sides of a domain that is given as a word.
    {"width", read_side<&Point3::x>},
    {"height", read_side<&Point3::y>},
    {"depth", read_side<&Point3::z>},
}};

tl::unexpected<Error> wrong(std::string_view option, std::string_view what) {
    return failure(ErrorCode::Malformed, std::string(option).append(" ").append(what), std::string(option));
}

/// Determines the sides of a domain that is given as a word.
Result<void> settle_domain(Draft& draft) {
    VolumeRequest& request = draft.request;
    const auto& [width, height, depth] = draft.sides;
    const bool any_side = width > 0 || height > 0 || depth > 0;
    if (any_side && (draft.is_object || request.solid))
        return wrong("domain", "must be the word box or torus if width, height or depth is an option");
    if (request.solid.has_value() != (draft.word == DomainWord::Solid))
        return wrong("domain", "must be solid for a mesh, and cannot be solid without a mesh");
    if (draft.is_object || request.solid) return {};
    const auto* file = std::get_if<VoxelFile>(&request.density);
    const auto side_or = [&](double given, std::size_t axis) {
        return given > 0 || file == nullptr ? given : static_cast<double>(file->voxels[axis]);
    };
    request.domain = {{side_or(width, 0), side_or(height, 1), side_or(depth, 2)}, draft.word == DomainWord::Torus};
    const Point3& sides = request.domain.sides;
    if (sides.x > 0 && sides.y > 0 && sides.z > 0) return {};
    return wrong("domain", "must have the members type, width, height and depth");
}

Result<void> check_quality(const VolumeRequest& request) {
    if (request.run.quality != Quality::Stealthy) return {};
    if (request.solid || !request.domain.periodic) return wrong("quality", "stealthy needs a domain of the type torus");
    if (!std::holds_alternative<std::monostate>(request.density))
        return wrong("quality", "stealthy needs a uniform density");
    if (!request.run.fixed.empty()) return wrong("quality", "stealthy allows no fixed points");
    constexpr double kFewest = 16;  // sites in a cube; with fewer, power above -100 dB may remain
    const auto& [x, y, z] = request.domain.sides;
    const double side = std::min({x, y, z});
    if (static_cast<double>(request.run.sites) >= kFewest * (x / side) * (y / side) * (z / side)) return {};
    return wrong("quality", "stealthy needs at least 16 sites for each cube with the shortest side of the torus");
}

/// Reads options and checks their combination.
/// @param draft  contains the body, if it is not JSON
Result<VolumeRequest> parse(Draft draft, std::span<const Input> inputs, std::string_view accept, const Limits& limits) {
    const auto located = [&](Error error) { return draft.request.located(std::move(error)); };
    ErrorList errors;
    errors.add(read_options<Draft>(kRules, inputs, limits, draft));
    if (std::ranges::find(inputs, "sites", &Input::name) == inputs.end())
        errors.add(Result<void>(wrong("sites", "is missing")).map_error(located));
    if (auto read = errors.result(); !read) return tl::unexpected(read.error());
    auto& [request, run, word, is_object, sides] = draft;
    request.run.sites = run.sites;
    request.run.seed = run.seed;
    request.run.quality = run.quality;
    request.run.keep_mesh = run.keep_mesh;
    errors.add(settle_domain(draft).map_error(located));
    errors.add(check_quality(request).map_error(located));
    auto settled = settle_format(accept, volume_formats(), request.format);
    if (settled) settled = check_mesh(*request.format, run.keep_mesh).map_error(located);
    errors.add(settled);
    if (auto right = errors.result(); !right) return tl::unexpected(right.error());
    return std::move(request);
}

/// Parses options that are given as text. Fields of errors then have no slash at their start.
Result<VolumeRequest> parse_text(Draft draft, const std::vector<TextOption>& options, std::string_view accept,
                                 const Limits& limits) {
    return parse(std::move(draft), inputs_of(options), accept, limits).map_error([](Error error) {
        const auto shorten = [](Error& each) { each.field.erase(0, each.field.starts_with('/') ? 1 : 0); };
        shorten(error);
        std::ranges::for_each(error.others, shorten);
        return error;
    });
}

}  // namespace

Error VolumeRequest::located(Error error) const {
    if (is_json && !error.field.empty() && !error.field.starts_with('/')) error.field.insert(0, "/");
    return error;
}

std::vector<std::string_view> volume_options() {
    return names_of<Draft>(kRules);
}

bool asks_for_volume(JsonValue root) {
    const auto domain = root.is_object() ? root.find("domain") : std::nullopt;
    if (!domain || !domain->is_object()) return false;
    const auto format = root.find("format");
    if (format && format->is_string() && format->text().starts_with("mask")) return false;
    const auto type = domain->find("type");
    return domain->find("depth") || (type && type->is_string() && type->text() == "box");
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
    draft.request.is_json = true;
    return parse(std::move(draft), *inputs, accept, limits);
}

Result<VolumeRequest> parse_volume(Result<VoxelFile> voxels, const std::vector<TextOption>& options,
                                   std::string_view accept, const Limits& limits) {
    if (!voxels) return tl::unexpected(voxels.error());
    if (std::ranges::find(options, "density", &TextOption::name) != options.end())
        return wrong("density", "is given twice, because the body has voxels");
    Draft draft;
    draft.request.density = *std::move(voxels);
    return parse_text(std::move(draft), options, accept, limits);
}

Result<VolumeRequest> parse_solid(Result<SurfaceFile> mesh, const std::vector<TextOption>& options,
                                  std::string_view accept, const Limits& limits) {
    if (!mesh) return tl::unexpected(mesh.error());
    Draft draft;
    draft.request.solid = *std::move(mesh);
    return parse_text(std::move(draft), options, accept, limits);
}

}  // namespace ccdt::api
