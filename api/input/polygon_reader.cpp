#include "api/input/polygon_reader.h"

#include <charconv>
#include <utility>

namespace ccdt::api {
namespace {

enum class Ordinates { Two, TwoOrMore };

tl::unexpected<Error> wrong(const std::string& pointer, std::string_view what) {
    return failure(ErrorCode::Malformed, pointer + ' ' + std::string(what), pointer);
}

Input element_of(const Input& parent, std::size_t index, JsonValue value) {
    const std::string pointer = pointer_below(parent.field, index);
    return {pointer, pointer, value};
}

/// Gives the value of an input that came in a JSON body, as all polygons do.
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

/// Reads each element of an array.
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

Result<PolygonPart> read_part(const Input& input) {
    auto rings = read_ring_list(input, Ordinates::TwoOrMore);
    if (!rings) return tl::unexpected(rings.error());
    if (rings->empty()) return failure(ErrorCode::Unusable, input.field + " is an empty polygon", input.field);
    PolygonPart part{std::move(rings->front()), {}};
    part.holes.assign(std::move_iterator(rings->begin() + 1), std::move_iterator(rings->end()));
    return part;
}

Result<std::vector<PolygonPart>> read_parts(const Input& input, PolygonInput::Nesting nesting) {
    if (nesting == PolygonInput::Nesting::MultiPolygon) {
        auto parts = read_each<PolygonPart>(input, "must be a list of polygons", read_part);
        if (parts && parts->empty()) {
            return failure(ErrorCode::Unusable, input.field + " holds no polygon", input.field);
        }
        return parts;
    }
    return read_part(input).map([](PolygonPart&& part) {
        std::vector<PolygonPart> parts;
        parts.push_back(std::move(part));
        return parts;
    });
}

/// Finds a member that must be there.
Result<Input> require(const Input& object, std::string_view name) {
    const std::string pointer = pointer_below(object.field, name);
    const auto value = json_of(object).find(name);
    if (!value) return wrong(pointer, "is missing");
    return Input{pointer, pointer, *value};
}

Result<std::string_view> read_type(const Input& object) {
    if (!json_of(object).is_object()) return wrong(object.field, "must be a GeoJSON object");
    return require(object, "type").and_then([](const Input& type) { return read_text(type); });
}

Result<PolygonInput> read_bare_geometry(const Input& input) {
    using Nesting = PolygonInput::Nesting;
    const auto type = read_type(input);
    if (!type) return tl::unexpected(type.error());
    if (*type != "Polygon" && *type != "MultiPolygon") {
        return wrong(input.field, "must be a Polygon, a MultiPolygon or a Feature of one, not a " + excerpt(*type));
    }
    const auto coordinates = require(input, "coordinates");
    if (!coordinates) return tl::unexpected(coordinates.error());
    const Nesting nesting = *type == "Polygon" ? Nesting::Polygon : Nesting::MultiPolygon;
    auto parts = read_parts(*coordinates, nesting);
    if (!parts) return tl::unexpected(parts.error());
    return PolygonInput{*std::move(parts), nesting, coordinates->field};
}

/// Takes a number off the front of `/3/0/17`.
std::size_t take_index(std::string_view& field) {
    std::size_t index = 0;
    field.remove_prefix(1);
    const auto [stopped, error] = std::from_chars(field.data(), field.data() + field.size(), index);
    field.remove_prefix(static_cast<std::size_t>(stopped - field.data()));
    return index;
}

}  // namespace

std::size_t PolygonInput::corner_count() const {
    std::size_t count = 0;
    for (const auto& part : parts) {
        count += part.outer.size();
        for (const auto& hole : part.holes) count += hole.size();
    }
    return count;
}

std::string PolygonInput::locate(std::string_view field) const {
    if (nesting == Nesting::MultiPolygon) return coordinates + std::string(field);
    if (!field.empty()) take_index(field);  // the one part there is
    if (nesting == Nesting::Polygon) return coordinates + std::string(field);
    const std::size_t ring = field.empty() ? 0 : take_index(field);
    const std::string pointer = ring == 0 ? "/polygon" : pointer_below("/holes", ring - 1);
    return pointer + std::string(field);
}

Result<Ring> read_ring(const Input& input) {
    return read_positions(input, Ordinates::Two);
}

Result<std::vector<Ring>> read_rings(const Input& input) {
    return read_ring_list(input, Ordinates::Two);
}

Result<PolygonInput> read_geometry(const Input& input) {
    const auto type = read_type(input);
    if (!type) return tl::unexpected(type.error());
    if (*type != "Feature") return read_bare_geometry(input);
    return require(input, "geometry").and_then(read_bare_geometry);
}

Result<void> check_size(const PolygonInput& polygon) {
    const std::size_t corners = polygon.corner_count();
    if (corners <= PolygonInput::kMaxCorners) return {};
    return failure(ErrorCode::LimitExceeded,
                   "the polygon has " + std::to_string(corners) + " corners; the limit is " +
                       std::to_string(PolygonInput::kMaxCorners),
                   polygon.locate({}));
}

}  // namespace ccdt::api
