// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/input/polygon_reader.h"

#include <algorithm>
#include <charconv>
#include <iterator>
#include <optional>
#include <utility>

namespace ccdt::api {
namespace {

enum class Ordinates { Two, TwoOrMore };

tl::unexpected<Error> wrong(const std::string& pointer, std::string_view what) {
    const std::string subject = pointer.empty() ? "the body" : pointer;
    return failure(ErrorCode::Malformed, subject + ' ' + std::string(what), pointer);
}

tl::unexpected<Error> not_a_polygon(const std::string& pointer, std::string_view type) {
    return wrong(pointer, "must be a Polygon, a MultiPolygon, a Feature of one, or a collection of these, not a " +
                              excerpt(type));
}

Input element_of(const Input& parent, std::size_t index, JsonValue value) {
    const std::string pointer = pointer_below(parent.field, index);
    return {pointer, pointer, value};
}

/// Returns the JSON value of an input. Polygons are given in JSON only.
JsonValue json_of(const Input& input) {
    return std::get<JsonValue>(input.value);
}

bool read_position(JsonValue value, Ordinates ordinates, Point& point) {
    if (!value.is_array() || value.size() < 2) return false;
    if (ordinates == Ordinates::Two && value.size() > 2) return false;
    auto i = value.begin();
    const JsonValue x = *i;
    const JsonValue y = *++i;
    if (!x.is_number() || !y.is_number()) return false;
    point = {x.number(), y.number()};
    return true;
}

Result<Ring> read_positions(const Input& input, Ordinates ordinates) {
    const JsonValue list = json_of(input);
    if (!list.is_array()) return wrong(input.field, "must be a list of positions [x, y]");
    Ring ring;
    ring.reserve(list.size());
    for (const JsonValue element : list) {
        Point point;
        if (!read_position(element, ordinates, point)) {
            return wrong(pointer_below(input.field, ring.size()), "must be a position [x, y]");
        }
        ring.push_back(point);
    }
    return ring;
}

template <class T, class Read>
Result<std::vector<T>> read_each(const Input& input, std::string_view expected, Read read) {
    const JsonValue list = json_of(input);
    if (!list.is_array()) return wrong(input.field, expected);
    std::vector<T> result;
    for (const JsonValue element : list) {
        Result<T> item = read(element_of(input, result.size(), element));
        if (!item) return tl::unexpected(item.error());
        result.push_back(*std::move(item));
    }
    return result;
}

Result<std::vector<Ring>> read_ring_list(const Input& input, Ordinates ordinates) {
    return read_each<Ring>(input, "must be a list of rings",
                           [=](const Input& ring) { return read_positions(ring, ordinates); });
}

/// Reads a list of rings. The outer ring is empty if there is none.
Result<PolygonPart> read_part(const Input& input) {
    auto rings = read_ring_list(input, Ordinates::TwoOrMore);
    if (!rings) return tl::unexpected(rings.error());
    PolygonPart part;
    if (rings->empty()) return part;
    part.outer = std::move(rings->front());
    part.holes.assign(std::move_iterator(rings->begin() + 1), std::move_iterator(rings->end()));
    return part;
}

Result<std::string_view> read_type(const Input& object) {
    if (!json_of(object).is_object()) return wrong(object.field, "must be a GeoJSON object");
    return require(object, "type").and_then([](const Input& type) { return read_text(type); });
}

Result<void> append_polygons(const Input& object, PolygonInput::Nesting nesting, PolygonInput& polygon) {
    const auto coordinates = require(object, "coordinates");
    if (!coordinates) return tl::unexpected(coordinates.error());
    std::vector<PolygonPart> parts;
    if (nesting == PolygonInput::Nesting::Polygon) {
        if (auto read = assign(parts.emplace_back(), read_part(*coordinates)); !read) return read;
    } else {
        auto list = read_each<PolygonPart>(*coordinates, "must be a list of polygons", read_part);
        if (auto read = assign(parts, std::move(list)); !read) return read;
    }
    polygon.append({nesting, coordinates->field}, std::move(parts), object.field);
    return {};
}

Result<void> append_geometry(const Input& object, PolygonInput& polygon);

/// Appends the geometries of all elements of a member.
Result<void> append_each(const Input& collection, std::string_view member, PolygonInput& polygon) {
    const auto list = require(collection, member);
    if (!list) return tl::unexpected(list.error());
    if (!json_of(*list).is_array()) return wrong(list->field, "must be a list of GeoJSON objects");
    std::size_t index = 0;
    std::vector<std::size_t> first_parts;
    for (const JsonValue element : json_of(*list)) {
        first_parts.push_back(polygon.parts.size());
        if (auto read = append_geometry(element_of(*list, index++, element), polygon); !read) return read;
    }
    if (member == "features") polygon.features = std::move(first_parts);
    return {};
}

Result<void> append_feature(const Input& feature, PolygonInput& polygon) {
    const auto geometry = require(feature, "geometry");
    if (!geometry) return tl::unexpected(geometry.error());
    if (!json_of(*geometry).is_null()) return append_geometry(*geometry, polygon);
    polygon.omit("null", geometry->field);
    return {};
}

/// Recurses at most as deep as a JsonDocument can nest.
Result<void> append_geometry(const Input& object, PolygonInput& polygon) {
    using Nesting = PolygonInput::Nesting;
    const auto type = read_type(object);
    if (!type) return tl::unexpected(type.error());
    if (*type == "Polygon") return append_polygons(object, Nesting::Polygon, polygon);
    if (*type == "MultiPolygon") return append_polygons(object, Nesting::MultiPolygon, polygon);
    if (*type == "GeometryCollection") return append_each(object, "geometries", polygon);
    if (*type == "FeatureCollection") return append_each(object, "features", polygon);
    if (*type == "Feature") return append_feature(object, polygon);
    if (polygon.omit(*type, object.field)) return {};
    return not_a_polygon(object.field, *type);
}

/// Removes and returns the number at the front of a field such as `/3/0/17`.
std::size_t take_index(std::string_view& field) {
    std::size_t index = 0;
    field.remove_prefix(1);
    const auto [stopped, error] = std::from_chars(field.data(), field.data() + field.size(), index);
    field.remove_prefix(static_cast<std::size_t>(stopped - field.data()));
    return index;
}

/// Removes the vertex from a field such as `/ring/vertex`.
std::string ring_of(std::string_view field) {
    return std::string(field.substr(0, field.find('/', 1)));
}

/// Removes the vertex from a field if the ring in the request has no vertex with this index.
std::string_view without_added(std::string_view field, const std::vector<PolygonPart>& parts) {
    std::string_view rest = field;
    const PolygonPart& part = parts[take_index(rest)];
    if (rest.empty()) return field;
    const std::size_t ring = take_index(rest);
    if (rest.empty()) return field;
    const std::string_view of_ring = field.substr(0, field.size() - rest.size());
    const std::size_t vertices = ring == 0 ? part.outer.size() : part.holes[ring - 1].size();
    return take_index(rest) < vertices ? field : of_ring;
}

}  // namespace

bool PolygonInput::omit(std::string_view kind, const std::string& pointer) {
    static constexpr std::string_view kKinds[] = {"null",       "empty",      "Point",
                                                  "MultiPoint", "LineString", "MultiLineString"};
    const std::string_view* const known = std::ranges::find(kKinds, kind);
    if (known == std::end(kKinds)) return false;
    auto same = std::ranges::find(omitted, kind, &Omitted::kind);
    if (same == omitted.end()) same = omitted.insert(same, {*known, pointer});
    ++same->count;
    return true;
}

void PolygonInput::append(const Source& source, std::vector<PolygonPart> geometry, const std::string& pointer) {
    const std::size_t before = parts.size();
    bool is_next = false;  // whether the last source has the part before this one
    for (std::size_t i = 0; i < geometry.size(); ++i) {
        const bool is_kept = !geometry[i].outer.empty();
        if (is_kept && !is_next) sources.push_back({source.nesting, source.coordinates, parts.size(), i});
        if (is_kept) parts.push_back(std::move(geometry[i]));
        is_next = is_kept;
    }
    if (parts.size() == before) omit("empty", pointer);
}

Result<void> PolygonInput::check(const Input& input) const {
    if (!parts.empty()) return {};
    const auto other =
        std::ranges::find_if(omitted, [](const Omitted& each) { return each.kind != "null" && each.kind != "empty"; });
    if (other != omitted.end()) return not_a_polygon(other->first, other->kind);
    return failure(ErrorCode::Unusable, input.name + " contains no polygon", input.field);
}

std::size_t PolygonInput::corner_count() const {
    std::size_t count = 0;
    for (const auto& part : parts) {
        count += part.outer.size();
        for (const auto& hole : part.holes) count += hole.size();
    }
    return count;
}

std::string PolygonInput::pointer_to(std::string_view field) const {
    if (field.empty() && sources.size() > 1) return {};  // the error is about all sources
    if (field.empty()) return sources.front().nesting == Nesting::Members ? "/polygon" : sources.front().coordinates;
    field = without_added(field, parts);
    const std::size_t part = take_index(field);
    const auto after = std::ranges::upper_bound(sources, part, {}, &Source::first_part);
    const Source& source = *std::prev(after);
    switch (source.nesting) {
        case Nesting::Rings: {
            std::string pointer = pointer_below(source.coordinates, source.index_of(part));
            if (!field.empty()) take_index(field);  // the part's only ring
            return pointer.append(field);
        }
        case Nesting::Polygon:
            return source.coordinates + std::string(field);
        case Nesting::MultiPolygon:
            return pointer_below(source.coordinates, source.index_of(part)) + std::string(field);
        case Nesting::ArcsOfPolygon:
            return source.coordinates + ring_of(field);
        case Nesting::ArcsOfMultiPolygon:
            return pointer_below(source.coordinates, source.index_of(part)) + ring_of(field);
        case Nesting::Members:
            break;
    }
    const std::size_t ring = field.empty() ? 0 : take_index(field);
    const std::string pointer = ring == 0 ? "/polygon" : pointer_below("/holes", ring - 1);
    return pointer + std::string(field);
}

PolygonInput polygons_of(std::optional<PolygonInput> geometry, std::optional<Ring> polygon,
                         std::optional<std::vector<Ring>> holes) {
    if (geometry) return *std::move(geometry);
    PolygonInput polygons;
    polygons.parts.push_back({*std::move(polygon), std::move(holes).value_or(std::vector<Ring>())});
    return polygons;
}

Result<Input> require(const Input& object, std::string_view name) {
    const std::string pointer = pointer_below(object.field, name);
    const auto value = json_of(object).find(name);
    if (!value) return wrong(pointer, "is missing");
    return Input{pointer, pointer, *value};
}

Result<Ring> read_ring(const Input& input) {
    return read_positions(input, Ordinates::Two);
}

Result<std::vector<Ring>> read_rings(const Input& input) {
    return read_ring_list(input, Ordinates::Two);
}

bool is_geojson(JsonValue value) {
    return value.is_object() && value.find("type");
}

Result<PolygonInput> read_geometry(const Input& input) {
    PolygonInput polygon{{}, {}};
    auto checked = append_geometry(input, polygon).and_then([&] { return polygon.check(input); });
    return std::move(checked).map([&] { return std::move(polygon); });
}

Result<PolygonInput> read_areas(const Input& input) {
    PolygonInput areas{{}, {}};
    if (!json_of(input).is_array()) {
        if (auto read = append_geometry(input, areas); !read) return tl::unexpected(read.error());
        const auto checked = areas.check(input);
        if (!checked && checked.error().code == ErrorCode::Malformed) return tl::unexpected(checked.error());
        return areas;
    }
    auto rings = read_rings(input);
    if (!rings) return tl::unexpected(rings.error());
    for (Ring& ring : *rings) areas.parts.push_back({std::move(ring), {}});
    areas.sources.push_back({PolygonInput::Nesting::Rings, input.field});
    return areas;
}

Result<void> check_size(const PolygonInput& polygon) {
    const std::size_t corners = polygon.corner_count();
    if (corners <= PolygonInput::kMaxCorners) return {};
    return failure(ErrorCode::LimitExceeded,
                   "the polygon has " + std::to_string(corners) + " corners; the limit is " +
                       std::to_string(PolygonInput::kMaxCorners),
                   polygon.pointer_to({}));
}

}  // namespace ccdt::api
