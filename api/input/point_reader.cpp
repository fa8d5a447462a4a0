// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/input/point_reader.h"

#include <array>
#include <string>
#include <utility>

namespace ccdt::api {
namespace {

JsonValue json_of(const Input& input) {
    return std::get<JsonValue>(input.value);
}

Input input_at(const std::string& pointer, JsonValue value) {
    return {pointer, pointer, value};
}

tl::unexpected<Error> too_many(const Input& position, const Limits& limits) {
    return failure(ErrorCode::LimitExceeded,
                   "there are more points than this server's limit (max-sites), " + std::to_string(limits.max_sites),
                   position.field);
}

/// Collects the points of GeoJSON objects.
class Collector {
public:
    explicit Collector(const Limits& limits) : limits_(limits) {}

    std::vector<Point> take() { return std::move(points_); }

    /// Recurses at most as deep as a JsonDocument can nest.
    Result<void> add_object(const Input& object) {
        if (!json_of(object).is_object()) return malformed(object, "must be a list of positions, or a GeoJSON object");
        const auto type = require(object, "type").and_then([](const Input& input) { return read_text(input); });
        if (!type) return tl::unexpected(type.error());
        if (*type == "Point") return in_member(object, "coordinates", &Collector::add_position);
        if (*type == "MultiPoint") return in_member(object, "coordinates", &Collector::add_positions);
        if (*type == "Feature") return in_member(object, "geometry", &Collector::add_object);
        if (*type == "GeometryCollection") return in_member(object, "geometries", &Collector::add_objects);
        if (*type == "FeatureCollection") return in_member(object, "features", &Collector::add_objects);
        return malformed(object, "must be a Point, a MultiPoint, a Feature of one, or a collection of these, not a " +
                                     excerpt(*type));
    }

    Result<void> add_positions(const Input& list) {
        if (!json_of(list).is_array()) return malformed(list, "must be a list of positions [x, y]");
        return for_each(list, &Collector::add_position);
    }

private:
    using Add = Result<void> (Collector::*)(const Input&);

    static Result<Input> require(const Input& object, std::string_view name) {
        const std::string pointer = pointer_below(object.field, name);
        const auto value = json_of(object).find(name);
        if (!value) return failure(ErrorCode::Malformed, pointer + " is missing", pointer);
        return input_at(pointer, *value);
    }

    Result<void> in_member(const Input& object, std::string_view name, Add add) {
        const auto member = require(object, name);
        if (!member) return tl::unexpected(member.error());
        return (this->*add)(*member);
    }

    Result<void> for_each(const Input& list, Add add) {
        std::size_t index = 0;
        for (const JsonValue element : json_of(list)) {
            if (auto added = (this->*add)(input_at(pointer_below(list.field, index++), element)); !added) return added;
        }
        return {};
    }

    Result<void> add_objects(const Input& list) {
        if (!json_of(list).is_array()) return malformed(list, "must be a list of GeoJSON objects");
        return for_each(list, &Collector::add_element);
    }

    Result<void> add_element(const Input& object) {
        const auto geometry = json_of(object).is_object() ? json_of(object).find("geometry") : std::nullopt;
        return geometry && geometry->is_null() ? Result<void>() : add_object(object);
    }

    Result<void> add_position(const Input& position) {
        const JsonValue value = json_of(position);
        if (!value.is_array() || value.size() < 2) return malformed(position, "must be a position [x, y]");
        auto ordinate = value.begin();
        const JsonValue x = *ordinate, y = *++ordinate;
        if (!x.is_number() || !y.is_number()) return malformed(position, "must be a position [x, y]");
        if (points_.size() == limits_.max_sites) return too_many(position, limits_);
        points_.push_back({x.number(), y.number()});
        return {};
    }

    const Limits& limits_;
    std::vector<Point> points_;
};

}  // namespace

Result<std::vector<Point>> read_points(const Input& input, const Limits& limits) {
    Collector collector(limits);
    const auto read = json_of(input).is_array() ? collector.add_positions(input) : collector.add_object(input);
    if (!read) return tl::unexpected(read.error());
    return collector.take();
}

Result<std::vector<Point3>> read_points3(const Input& input, const Limits& limits) {
    if (std::holds_alternative<std::string_view>(input.value)) {
        return parse_list(input).and_then([&](const JsonDocument& document) {
            return read_points3({input.name, input.field, document.root()}, limits);
        });
    }
    if (!json_of(input).is_array()) return malformed(input, "must be a list of positions [x, y, z]");
    std::vector<Point3> points;
    for (const JsonValue element : json_of(input)) {
        const Input position = input_at(pointer_below(input.field, points.size()), element);
        std::array<double, 3> ordinates{};
        std::size_t count = 0;
        if (element.is_array() && element.size() == ordinates.size()) {
            for (const JsonValue value : element) {
                if (value.is_number()) ordinates[count++] = value.number();
            }
        }
        if (count < ordinates.size()) return malformed(position, "must be a position [x, y, z]");
        if (points.size() == limits.max_sites) return too_many(position, limits);
        points.push_back({ordinates[0], ordinates[1], ordinates[2]});
    }
    return points;
}

}  // namespace ccdt::api
