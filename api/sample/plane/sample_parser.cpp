// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/plane/sample_parser.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <optional>
#include <span>
#include <utility>

#include "api/image/embedded_image.h"
#include "api/input/negotiation.h"
#include "api/input/point_reader.h"
#include "api/input/run_options.h"
#include "api/input/topology_reader.h"
#include "api/output/formats.h"
#include "api/sample/plane/map_drawing.h"
#include "core/ccdt/maps/middle.h"
#include "core/ccdt/polish/stealth.h"

namespace ccdt::api {
namespace {

constexpr std::uint64_t kMaxWidth = 65'535;

constexpr Interval kNotNegative = {.min = 0};

/// A request that is being parsed. Its options have been read, but their combination has not been checked yet.
struct Draft {
    SampleRequest request;
    std::optional<Ring> polygon;
    std::optional<std::vector<Ring>> holes;
    std::optional<PolygonInput> geometry;
    std::optional<FeatureSource>
        source;  ///< features of the geometry; refers to the JSON document, which must still exist
    std::optional<std::string> object;  ///< name of an object of TopoJSON
    std::optional<Rectangle> rectangle;
    std::optional<double> depth;  ///< of the domain of a mask
    Counting counting;
    std::optional<PropertyChoice> properties;
    std::optional<std::uint64_t> min_zoom, dots_per_tile;
    MethodOptions given{};
};

/// Reads an option that only some methods support, and records that the option was given.
template <Result<void> (*kRead)(const Input&, Options&), bool MethodOptions::*kGiven>
Result<void> read_given(const Input& input, const Limits&, Draft& draft) {
    draft.given.*kGiven = true;
    return kRead(input, draft.request.run);
}

Result<void> read_tolerance(const Input& input, Options& options) {
    return assign(options.tolerance, read_number(input, kPositive));
}

Result<void> read_per(const Input& input, Counting& counting) {
    if (counting.per) return malformed(input, "is also given in sites: give only one of them");
    return assign(counting.per, read_per(input));
}

Result<OnInvalid> read_invalid(const Input& input) {
    static constexpr Choice<OnInvalid> kWords[] = {{"repair", OnInvalid::Repair}, {"reject", OnInvalid::Reject}};
    return read_choice<OnInvalid>(input, kWords);
}

Result<Coordinates> read_coordinates(const Input& input) {
    static constexpr Choice<Coordinates> kWords[] = {{"plane", Coordinates::Plane}, {"lonlat", Coordinates::LonLat}};
    return read_choice<Coordinates>(input, kWords);
}

/// Reads an excluded picture: an image whose dark area is subtracted from the domain.
Result<void> read_exclude(const Input& input, const Limits& limits, Draft& draft) {
    static constexpr std::array<OptionRule<SampleRegion>, 1> kRules = {{
        {"/exclude/image",
         [](const Input& i, const Limits& l, SampleRegion& r) { return assign(r.exclude, read_embedded_image(i, l)); }},
    }};
    const auto object = std::get<JsonValue>(input.value);
    SampleRegion& region = draft.request.region;
    if (auto read = read_members<SampleRegion>(kRules, object, input.field, limits, region); !read) return read;
    if (!region.exclude) return malformed(input, "must have the member image");
    return {};
}

/// Reads an object of TopoJSON, and stores a reference to its features.
Result<void> read_topology(const Input& input, Draft& draft) {
    const auto object = find_object(input, draft.object);
    if (!object) return tl::unexpected(object.error());
    auto read = assign(draft.geometry, read_topology(input, *object));
    if (read) draft.source = find_geometries(*object);
    return read;
}

/// Finds the reference system that the member `crs` of GeoJSON names.
std::optional<ReferenceSystem> find_system(JsonValue geojson) {
    std::optional<JsonValue> value = geojson;
    for (const std::string_view name : {"crs", "properties", "name"})
        value = value && value->is_object() ? value->find(name) : std::nullopt;
    return value && value->is_string() ? recognise_reference_system(value->text()) : std::nullopt;
}

/// Reads GeoJSON or TopoJSON, and stores a reference to its features.
Result<void> read_geometry(const Input& input, Draft& draft) {
    if (is_topology(std::get<JsonValue>(input.value))) return read_topology(input, draft);
    if (draft.object)
        return failure(ErrorCode::Malformed, "object is an option of TopoJSON only", draft.request.field_of("object"));
    auto read = assign(draft.geometry, read_geometry(input));
    if (!read) return read;
    draft.source = find_features(input);
    draft.request.region.system = find_system(std::get<JsonValue>(input.value));
    return {};
}

Result<std::uint64_t> read_zoom(const Input& input) {
    return read_integer(input, 0, DotTiles::kMaxZoom);
}

/// Reads the number of sites, or the name of the property that holds the counts.
Result<void> read_sites(const Input& input, const Limits& limits, Draft& draft) {
    if (is_counted(input)) return read_counted(input, draft.counting);
    return assign(draft.request.run.sites, read_sites(input, limits));
}

/// Reads a format of points or of masks.
Result<void> read_any_format(const Input& input, Draft& draft) {
    const auto points = sample_formats();
    const auto masks = mask_formats();
    auto files = files_of(points);
    const auto others = files_of(masks);
    files.insert(files.end(), others.begin(), others.end());
    const auto chosen = read_format(input, files);
    if (!chosen) return tl::unexpected(chosen.error());
    draft.request.output.format = points[*chosen < points.size() ? *chosen : 0];
    if (*chosen >= points.size()) draft.request.threshold_mask = ThresholdMask{masks[*chosen - points.size()]};
    return {};
}

/// Reads a domain in the plane, or the domain of a mask with frames.
Result<void> read_domain(const Input& input, Draft& draft) {
    const auto* domain = std::get_if<JsonValue>(&input.value);
    if (domain == nullptr || !domain->is_object() || !domain->find("depth"))
        return assign(draft.rectangle, read_rectangle(input));
    return read_box(input).map([&](const BoxDomain3& box) {
        draft.rectangle = {box.sides.x, box.sides.y, box.periodic};
        draft.depth = box.sides.z;
    });
}

Result<void> read_fixed(const Input& input, const Limits& limits, Draft& draft) {
    draft.given.fixed = true;
    return assign(draft.request.run.fixed, read_points(input, limits));
}

/// Options that only a JSON body can have, because their values are objects or arrays.
constexpr std::array<OptionRule<Draft>, 8> kShapeRules = {{
    {"polygon", [](const Input& i, const Limits&, Draft& d) { return assign(d.polygon, read_ring(i)); }},
    {"holes", [](const Input& i, const Limits&, Draft& d) { return assign(d.holes, read_rings(i)); }},
    {"geometry", [](const Input& i, const Limits&, Draft& d) { return read_geometry(i, d); }},
    {"domain", [](const Input& i, const Limits&, Draft& d) { return read_domain(i, d); }},
    {"density",
     [](const Input& i, const Limits& l, Draft& d) { return assign(d.request.density, read_density(i, l)); }},
    {"fixed", read_fixed},
    {"exclude", read_exclude},
    {"avoid", [](const Input& i, const Limits&, Draft& d) { return assign(d.request.region.avoid, read_areas(i)); }},
}};

DrawingOptions& drawing_of(Draft& draft) {
    return draft.request.output.drawing;
}

/// Options that are members of a JSON body, or parameters if the body is a GeoJSON or TopoJSON document.
constexpr auto kPointRules = std::to_array<OptionRule<Draft>>({
    {"sites", read_sites},
    {"per", [](const Input& i, const Limits&, Draft& d) { return read_per(i, d.counting); }},
    {"classes", [](const Input& i, const Limits&, Draft& d) { return assign(d.counting.classes, read_classes(i)); }},
    {"object", [](const Input& i, const Limits&, Draft& d) { return assign(d.object, read_text(i)); }},
    {"properties", [](const Input& i, const Limits&, Draft& d) { return assign(d.properties, read_properties(i)); }},
    {"multipoint",
     [](const Input& i, const Limits&, Draft& d) { return assign(d.request.output.multipoint, read_boolean(i)); }},
    {"invalid",
     [](const Input& i, const Limits&, Draft& d) { return assign(d.request.region.on_invalid, read_invalid(i)); }},
    {"coordinates",
     [](const Input& i, const Limits&, Draft& d) { return assign(d.request.region.coordinates, read_coordinates(i)); }},
    {"buffer", [](const Input& i, const Limits&,
                  Draft& d) { return assign(d.request.region.buffer, read_number(i, kNotNegative)); }},
    {"seed", [](const Input& i, const Limits&, Draft& d) { return read_seed(i, d.request.run); }},
    {"iterations", read_given<read_iterations, &MethodOptions::iterations>},
    {"passes", read_given<read_passes, &MethodOptions::passes>},
    {"quality", read_given<read_quality, &MethodOptions::quality>},
    {"on_deadline",
     [](const Input& i, const Limits&, Draft& d) { return assign(d.request.on_deadline, read_on_deadline(i)); }},
    {"tolerance", read_given<read_tolerance, &MethodOptions::tolerance>},
    {"method", [](const Input& i, const Limits&, Draft& d) { return assign(d.request.method, read_method(i)); }},
    {"mesh", [](const Input& i, const Limits&, Draft& d) { return assign(d.request.run.keep_mesh, read_boolean(i)); }},
    {"order",
     [](const Input& i, const Limits&, Draft& d) { return assign(d.request.output.order, read_point_order(i)); }},
});

constexpr auto kOutputRules = std::to_array<OptionRule<Draft>>({
    {"width", [](const Input& i, const Limits&,
                 Draft& d) { return assign(d.request.output.width, read_integer(i, 1, kMaxWidth)); }},
    {"dot",
     [](const Input& i, const Limits&, Draft& d) { return assign(d.request.output.dot, read_number(i, kPositive)); }},
    {"outlines",
     [](const Input& i, const Limits&, Draft& d) { return assign(d.request.output.outlines, read_boolean(i)); }},
    {"legend",
     [](const Input& i, const Limits&, Draft& d) { return assign(d.request.output.legend, read_boolean(i)); }},
    {"format", [](const Input& i, const Limits&, Draft& d) { return read_any_format(i, d); }},
    {"minzoom", [](const Input& i, const Limits&, Draft& d) { return assign(d.min_zoom, read_zoom(i)); }},
    {"maxzoom",
     [](const Input& i, const Limits&, Draft& d) { return assign(d.request.output.tiles.max_zoom, read_zoom(i)); }},
    {"dots_per_tile", [](const Input& i, const Limits&,
                         Draft& d) { return assign(d.dots_per_tile, read_integer(i, 1, DotTiles::kMaxDots)); }},
});

constexpr auto kOptionRules = joined(kPointRules, drawing_rules<Draft, drawing_of>(), kOutputRules);

constexpr auto kRules = joined(kShapeRules, kOptionRules);

Result<void> missing_sites(const SampleRequest& request) {
    return failure(ErrorCode::Malformed, "sites is missing", request.field_of("sites"));
}

Result<void> not_one_shape() {
    return failure(ErrorCode::Malformed, "exactly one of polygon, geometry and domain must be given");
}

/// Checks that a request for a mask has only the options that masks have.
Result<void> check_members_of_mask(std::span<const Input> inputs, const SampleRequest& request) {
    constexpr std::string_view kMembers[] = {"domain", "seed", "format"};
    for (const Input& input : inputs) {
        if (std::ranges::find(kMembers, input.name) != std::end(kMembers)) continue;
        return failure(ErrorCode::Malformed,
                       "a mask has the options domain, seed and format only, not " + excerpt(input.name),
                       request.field_of(input.name));
    }
    return {};
}

/// Reads options and shapes. If some are invalid, the error also reports required options that are missing. If all are
/// valid, required options are checked later.
Result<void> read_inputs(std::span<const OptionRule<Draft>> rules, std::span<const Input> inputs, const Limits& limits,
                         Draft& draft) {
    const auto read = read_options<Draft>(rules, inputs, limits, draft);
    if (read) return draft.request.threshold_mask ? check_members_of_mask(inputs, draft.request) : read;
    const auto has_any = [&](std::initializer_list<std::string_view> names) {
        return std::ranges::find_first_of(inputs, names, {}, &Input::name) != inputs.end();
    };
    ErrorList errors;
    errors.add(read);
    if (!draft.request.threshold_mask && !has_any({"sites", "classes"})) errors.add(missing_sites(draft.request));
    if (!draft.request.is_document && !has_any({"polygon", "geometry", "domain"})) errors.add(not_one_shape());
    return errors.result();
}

/// Reads a body that is a GeoJSON or TopoJSON document, with options as text.
Result<void> read_document(JsonValue root, const std::vector<TextOption>& options, const Limits& limits, Draft& draft) {
    draft.request.is_document = true;
    ErrorList errors;
    errors.add(read_inputs(kOptionRules, inputs_of(options), limits, draft));
    errors.add(read_geometry({"the body", "", root}, draft));
    return errors.result();
}

/// Returns an error about options that cannot be combined.
tl::unexpected<Error> incompatible(const Draft& draft, std::string_view option, std::string_view what) {
    return failure(ErrorCode::Malformed, std::string(option).append(" ").append(what), draft.request.field_of(option));
}

/// Returns the middles of all features.
std::vector<std::optional<Point3>> middles(const Draft& draft) {
    const std::span<const PolygonPart> parts = draft.geometry->parts;
    // A single feature has all parts.
    const auto first_part = draft.source->is_collection ? draft.geometry->features : std::vector<std::size_t>{0};
    std::vector<std::optional<Point3>> positions;
    for (std::size_t i = 0; i < first_part.size(); ++i) {
        const std::size_t end = i + 1 < first_part.size() ? first_part[i + 1] : parts.size();
        positions.push_back(
            middle_of(parts.subspan(first_part[i], end - first_part[i]), draft.request.region.is_on_globe()));
    }
    return positions;
}

/// Computes the number of points of each feature, if the request is for a dot map.
Result<void> settle_counts(const Limits& limits, Draft& draft) {
    const Counting& counting = draft.counting;
    if (!counting.is_requested()) return {};
    const std::string_view option = counting.property ? "sites" : counting.classes.empty() ? "per" : "classes";
    if (draft.request.run.sites != 0) return incompatible(draft, option, "cannot be combined with a number of sites");
    if (counting.property && !counting.classes.empty())
        return incompatible(draft, "classes", "cannot be combined with a property in sites");
    if (!draft.source) return incompatible(draft, option, "needs a Feature, a FeatureCollection or TopoJSON");
    if (!counting.property && counting.classes.empty())
        return incompatible(draft, option,
                            "needs classes, or the name of a property in sites" + describe_properties(*draft.source));
    const auto names = counting.property ? std::span(&*counting.property, 1) : std::span(counting.classes);
    if (auto found = check_names(*draft.source, names, draft.request.field_of(option)); !found) return found;
    auto counts = count_features(*draft.source, middles(draft), counting, limits, draft.request.field_of("sites"));
    if (!counts) return tl::unexpected(counts.error());
    draft.request.run.sites = counts->total();
    draft.request.counts = *std::move(counts);
    return {};
}

/// Lists the features by which points are grouped, if the request asks for grouped points.
Result<void> settle_features(const Limits& limits, Draft& draft) {
    if (auto settled = settle_counts(limits, draft); !settled) return settled;
    if (draft.properties && !draft.source)
        return incompatible(draft, "properties", "needs a Feature, a FeatureCollection or TopoJSON");
    if (!draft.properties && !draft.request.counts) return {};
    auto features =
        list_features(*draft.source, draft.geometry->features, draft.geometry->parts.size(),
                      draft.properties ? &*draft.properties : nullptr, draft.request.field_of("properties"));
    return assign(draft.request.features, std::move(features));
}

Result<void> read_request(JsonValue root, const std::vector<TextOption>& options, const Limits& limits, Draft& draft) {
    if (is_geojson(root)) {
        if (auto read = read_document(root, options, limits, draft); !read) return read;
        return settle_features(limits, draft);
    }
    if (!options.empty())
        return failure(ErrorCode::Malformed,
                       "options must be members of the JSON body, unless the body is a GeoJSON document",
                       excerpt(options.front().name));
    auto inputs = inputs_of(root, "");
    if (!inputs) return tl::unexpected(inputs.error());
    // The option `object` must be read before the geometry.
    std::stable_partition(inputs->begin(), inputs->end(), [](const Input& input) { return input.name == "object"; });
    if (auto read = read_inputs(kRules, *inputs, limits, draft); !read) return read;
    return settle_features(limits, draft);
}

Result<void> check_sites(const SampleRequest& request) {
    if (request.run.sites > 0 || request.threshold_mask) return {};
    return missing_sites(request);
}

/// Checks that a request for a dot map has only options that dot maps support.
Result<void> check_map(const Draft& draft) {
    if (!draft.request.counts) return {};
    if (draft.request.method != &methods().front())
        return incompatible(draft, "method", "must be " + std::string(methods().front().name) + " for a dot map");
    if (draft.request.run.keep_mesh) return incompatible(draft, "mesh", "is not available for a dot map");
    return {};
}

/// Checks requests whose points carry properties: no mesh is requested, and the properties do not exceed the limit on
/// their size.
Result<void> check_properties(const Draft& draft) {
    const SampleRequest& request = draft.request;
    if (!draft.properties) return {};
    if (request.run.keep_mesh) return incompatible(draft, "mesh", "is not available for points that carry properties");
    if (!request.counts || !request.output.format->repeats_properties) return {};
    std::vector<std::size_t> points;
    for (std::size_t i = 0; i < request.features->size(); ++i) points.push_back(request.counts->points_of(i));
    return check_size(request.features->carried, points, request.field_of("properties"));
}

/// Chooses the format, by name or by the Accept header.
Result<void> settle_format(std::string_view accept, Draft& draft) {
    const PointFormat*& format = draft.request.output.format;
    if (auto settled = settle_format(accept, sample_formats(), format); !settled) return settled;
    format = &draft.request.output.variant_of(*format);
    return check_properties(draft);
}

/// Settles the zooms of tiles, and checks that only tiles have zooms.
Result<void> settle_tiles(Draft& draft) {
    SampleRequest& request = draft.request;
    DotTiles& tiles = request.output.tiles;
    const auto wrong = [&](const char* option, const char* message) {
        return failure(ErrorCode::Malformed, message, request.field_of(option));
    };
    if (!request.output.format->is_tiled()) {
        constexpr const char* kTiles = "minzoom, maxzoom and dots_per_tile are options of the format pmtiles only";
        if (draft.min_zoom) return wrong("minzoom", kTiles);
        if (tiles.max_zoom) return wrong("maxzoom", kTiles);
        return draft.dots_per_tile ? wrong("dots_per_tile", kTiles) : Result<void>();
    }
    if (request.region.coordinates != Coordinates::LonLat)
        return wrong("coordinates", "must be lonlat for the format pmtiles, whose tiles are places on the globe");
    if (request.output.order.value_or(PointOrder::Progressive) != PointOrder::Progressive)
        return wrong("order", "must be progressive for the format pmtiles: the order decides which dots a zoom shows");
    if (tiles.max_zoom && draft.dots_per_tile)
        return wrong("dots_per_tile", "maxzoom replaces dots_per_tile: give only one of them");
    request.output.order = PointOrder::Progressive;
    tiles.min_zoom = static_cast<int>(draft.min_zoom.value_or(0));
    tiles.dots_per_tile = draft.dots_per_tile.value_or(tiles.dots_per_tile);
    if (tiles.max_zoom.value_or(DotTiles::kMaxZoom) < tiles.min_zoom)
        return wrong("maxzoom", "must be at least minzoom");
    return {};
}

/// Checks that outlines and a legend can be drawn, if the request asks for them.
Result<void> check_figure(const SampleRequest& request) {
    const SampleOutput& output = request.output;
    const auto refused = [&](const char* option, const char* message) {
        return failure(ErrorCode::Malformed, std::string(option) + message, request.field_of(option));
    };
    constexpr const char* kDrawn =
        " is an option of drawings in one file: svg, pdf, eps, png and jpeg, with style=fill";
    const bool can_draw = can_draw_maps(*output.format, output.drawing);
    if (output.outlines && !can_draw) return refused("outlines", kDrawn);
    if (output.legend && !can_draw) return refused("legend", kDrawn);
    if (output.legend == true && !request.counts)
        return refused("legend", " needs a dot map: classes, or the name of a property in sites");
    return {};
}

/// Checks the areas that are subtracted from the domain.
Result<void> check_exclusions(const Draft& draft) {
    const SampleRequest& request = draft.request;
    if (draft.rectangle && draft.rectangle->periodic) {
        const auto refused = [](const char* field) {
            return failure(ErrorCode::Malformed,
                           "avoid, exclude and buffer need a domain with a border, which a torus does not have", field);
        };
        if (!request.region.avoid.parts.empty()) return refused("/avoid");
        if (request.region.exclude) return refused("/exclude");
        if (request.region.buffer > 0) return refused("/buffer");
    }
    auto checked = check_size(request.region.avoid);
    if (!checked) checked.error().field = "/avoid";
    return checked;
}

/// Checks that fixed points are on the globe, if their coordinates are longitudes and latitudes.
Result<void> check_fixed(const SampleRequest& request) {
    constexpr double kFarthest = 540, kPole = 90;  // as for polygons
    if (request.region.coordinates == Coordinates::Plane) return {};
    for (const Point& p : request.run.fixed) {
        if (std::abs(p.x) <= kFarthest && std::abs(p.y) <= kPole) continue;
        return failure(
            ErrorCode::Unusable,
            "the longitude of a fixed point must be from -540 to 540 degrees, and its latitude from -90 to 90",
            "/fixed");
    }
    return {};
}

Result<void> settle_domain(Draft& draft) {
    const int given = (draft.polygon ? 1 : 0) + (draft.geometry ? 1 : 0) + (draft.rectangle ? 1 : 0);
    if (given != 1) return not_one_shape();
    if (draft.holes && !draft.polygon) return failure(ErrorCode::Malformed, "holes needs the member polygon", "/holes");
    if (auto checked = check_exclusions(draft); !checked) return checked;
    if (draft.rectangle) {
        draft.request.region.domain = *draft.rectangle;
        if (draft.request.region.coordinates == Coordinates::Plane) return {};
        return failure(ErrorCode::Malformed, "coordinates must be plane if domain is given", "/coordinates");
    }
    PolygonInput polygon = polygons_of(std::move(draft.geometry), std::move(draft.polygon), std::move(draft.holes));
    if (auto checked = check_size(polygon); !checked) return checked;
    draft.request.region.domain = std::move(polygon);
    return {};
}

/// Completes a request for a threshold mask with its size and seed.
Result<void> settle_mask(std::optional<double> depth, SampleRequest& request) {
    const auto* torus = std::get_if<Rectangle>(&request.region.domain);
    if (auto checked = check_mask(torus, depth, request.field_of("format")); !checked) return checked;
    request.threshold_mask->torus = *torus;
    request.threshold_mask->depth = depth;
    request.threshold_mask->seed = request.run.seed;
    return {};
}

/// Checks that the quality stealthy is available for the request.
Result<void> check_quality(const Draft& draft) {
    const SampleRequest& request = draft.request;
    if (request.run.quality != Quality::Stealthy) return {};
    const auto refused = [&](std::string what) -> Result<void> {
        return failure(ErrorCode::Malformed, "quality stealthy " + std::move(what), request.field_of("quality"));
    };
    if (!draft.rectangle || !draft.rectangle->periodic) return refused("needs a domain of the type torus");
    if (!std::holds_alternative<std::monostate>(request.density)) return refused("needs a uniform density");
    if (!request.run.fixed.empty()) return refused("allows no fixed points");
    if (request.run.iterations == 0) return refused("needs at least one iteration");
    const double fewest = Stealth::fewest_sites({draft.rectangle->width, draft.rectangle->height});
    if (static_cast<double>(request.run.sites) >= fewest) return {};
    return refused(
        "needs at least four rows of points: 16 sites times the ratio of the longer side of the torus to the shorter "
        "one");
}

/// Sets the width in pixels, if it follows from the resolution.
Result<void> settle_width(SampleRequest& request) {
    SampleOutput& output = request.output;
    if (!output.drawing.dpi || !output.drawing.width_mm) return {};
    if (output.width)
        return failure(ErrorCode::Malformed, "width replaces dpi: give only one of them", request.field_of("width"));
    return request.about_option(assign(output.width, width_in_pixels(output.drawing)));
}

}  // namespace

std::vector<std::string_view> sample_options() {
    return names_of<Draft>(kRules);
}

Result<SampleRequest> parse_sample(JsonValue root, const std::vector<TextOption>& options, std::string_view accept,
                                   const Limits& limits) {
    Draft draft;
    if (auto read = read_request(root, options, limits, draft); !read) return tl::unexpected(read.error());
    ErrorList errors;
    errors.add(check_sites(draft.request));
    errors.add(check_map(draft));
    errors.add(settle_method(*draft.request.method, draft.given, draft.request.run).map_error([&](Error error) {
        if (draft.request.is_document) error.field.erase(0, 1);  // the slash of a JSON Pointer
        return error;
    }));
    errors.add(check_fixed(draft.request));
    errors.add(check_quality(draft));
    const auto domain = settle_domain(draft);
    errors.add(domain);
    if (domain && draft.request.threshold_mask) errors.add(settle_mask(draft.depth, draft.request));
    const auto format = settle_format(accept, draft);
    errors.add(format);
    if (format && !draft.request.threshold_mask) {
        errors.add(settle_tiles(draft));
        errors.add(check_figure(draft.request));
    }
    const SampleOutput& output = draft.request.output;
    errors.add(draft.request.about_option(check_effects(output.drawing, output.dot.has_value())));
    if (output.format != nullptr && !draft.request.threshold_mask) {
        errors.add(draft.request.about_option(output.format->check_kind(output.drawing)));
        errors.add(draft.request.about_option(output.format->check_drawing(output.drawing)));
    }
    errors.add(settle_width(draft.request));
    if (auto settled = errors.result(); !settled) return tl::unexpected(settled.error());
    return std::move(draft.request);
}

Result<SampleRequest> parse_sample(std::string_view body, const std::vector<TextOption>& options,
                                   std::string_view accept, const Limits& limits) {
    const auto document = JsonDocument::parse_features(body);
    if (!document) return tl::unexpected(document.error());
    return parse_sample(document->root(), options, accept, limits);
}

}  // namespace ccdt::api
