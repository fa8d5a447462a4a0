// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/input/topology_reader.h"

#include <cmath>
#include <cstddef>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

namespace ccdt::api {
namespace {

JsonValue json_of(const Input& input) {
    return std::get<JsonValue>(input.value);
}

Input below(const Input& parent, std::size_t index, JsonValue value) {
    const std::string pointer = pointer_below(parent.field, index);
    return {pointer, pointer, value};
}

/// Reads a pair of numbers. Ignores further numbers.
std::optional<Point> read_pair(JsonValue value) {
    if (!value.is_array() || value.size() < 2) return std::nullopt;
    auto i = value.begin();
    const JsonValue x = *i;
    const JsonValue y = *++i;
    if (!x.is_number() || !y.is_number()) return std::nullopt;
    return Point{x.number(), y.number()};
}

/// Affine map from the integers of quantized arcs to positions.
struct Transform {
    Point scale{1, 1};
    Point translate{0, 0};

    Point apply(Point p) const { return {p.x * scale.x + translate.x, p.y * scale.y + translate.y}; }
};

Result<std::optional<Transform>> read_transform(const Input& topology) {
    if (!json_of(topology).find("transform")) return std::nullopt;
    const auto given = require(topology, "transform");
    if (!json_of(*given).is_object()) return malformed(*given, "must be an object");
    Transform transform;
    for (const auto& [name, target] : {std::pair{"scale", &transform.scale}, {"translate", &transform.translate}}) {
        const auto member = require(*given, name);
        if (!member) return tl::unexpected(member.error());
        const auto pair = read_pair(json_of(*member));
        if (!pair) return malformed(*member, "must be two numbers");
        *target = *pair;
    }
    return transform;
}

/// Arcs of a document. Each arc is decoded on first use.
class Arcs {
public:
    static Result<Arcs> create(const Input& topology) {
        const auto transform = read_transform(topology);
        if (!transform) return tl::unexpected(transform.error());
        const auto list = require(topology, "arcs");
        if (!list) return tl::unexpected(list.error());
        if (!json_of(*list).is_array()) return malformed(*list, "must be a list of arcs");
        return Arcs(*list, *transform);
    }

    std::size_t size() const { return arcs_.size(); }

    /// Returns the positions of an arc.
    Result<std::span<const Point>> at(std::size_t index) {
        Arc& arc = arcs_[index];
        if (arc.is_decoded) return std::span<const Point>(arc.points);
        const Input input = below(list_, index, arc.value);
        if (!arc.value.is_array()) return malformed(input, "must be a list of positions [x, y]");
        Point sum;
        for (const JsonValue position : arc.value) {
            const auto given = read_pair(position);
            if (!given) return malformed(below(input, arc.points.size(), position), "must be a position [x, y]");
            sum = sum + *given;
            arc.points.push_back(transform_ ? transform_->apply(sum) : *given);
        }
        arc.is_decoded = true;
        return std::span<const Point>(arc.points);
    }

private:
    struct Arc {
        JsonValue value;
        bool is_decoded = false;
        std::vector<Point> points;
    };

    Arcs(Input list, const std::optional<Transform>& transform) : list_(std::move(list)), transform_(transform) {
        for (const JsonValue value : json_of(list_)) arcs_.push_back({value, false, {}});
    }

    Input list_;
    std::optional<Transform> transform_;
    std::vector<Arc> arcs_;
};

/// Reads the geometries of an object.
class Reader {
public:
    explicit Reader(Arcs arcs) : arcs_(std::move(arcs)) {}

    Result<PolygonInput> execute(const Input& object) {
        if (auto read = read_object(object, true); !read) return tl::unexpected(read.error());
        return polygon_.check(object).map([&] { return std::move(polygon_); });
    }

private:
    using Nesting = PolygonInput::Nesting;

    /// @param is_root  if true, the geometries of a collection are features
    Result<void> read_object(const Input& object, bool is_root) {
        if (!json_of(object).is_object()) return malformed(object, "must be an object of TopoJSON");
        const auto type = require(object, "type");
        if (!type) return tl::unexpected(type.error());
        if (json_of(*type).is_null()) {
            polygon_.omit("null", object.field);
            return {};
        }
        const auto name = read_text(*type);
        if (!name) return tl::unexpected(name.error());
        if (*name == "GeometryCollection") return read_collection(object, is_root);
        const bool is_multiple = *name == "MultiPolygon";
        if (!is_multiple && *name != "Polygon" && polygon_.omit(*name, object.field)) return {};
        if (!is_multiple && *name != "Polygon")
            return malformed(
                object, "must be a Polygon, a MultiPolygon or a GeometryCollection of these, not a " + excerpt(*name));
        const auto arcs = require(object, "arcs");
        if (!arcs) return tl::unexpected(arcs.error());
        std::vector<PolygonPart> parts;
        const auto append = [&](const Input& rings) { return read_part(rings, parts.emplace_back()); };
        auto read = is_multiple ? for_each(*arcs, "must be a list of polygons", append) : append(*arcs);
        if (!read) return read;
        polygon_.append({is_multiple ? Nesting::ArcsOfMultiPolygon : Nesting::ArcsOfPolygon, arcs->field},
                        std::move(parts), object.field);
        return {};
    }

    Result<void> read_collection(const Input& object, bool is_root) {
        const auto list = require(object, "geometries");
        if (!list) return tl::unexpected(list.error());
        std::vector<std::size_t> first_parts;
        auto read = for_each(*list, "must be a list of geometries", [&](const Input& geometry) {
            first_parts.push_back(polygon_.parts.size());
            return read_object(geometry, false);
        });
        if (is_root) polygon_.features = std::move(first_parts);
        return read;
    }

    /// Reads a list of rings. The outer ring stays empty if there is none.
    Result<void> read_part(const Input& rings, PolygonPart& part) {
        bool is_outer = true;
        return for_each(rings, "must be a list of rings", [&](const Input& ring) {
            return read_ring(ring, std::exchange(is_outer, false) ? part.outer : part.holes.emplace_back());
        });
    }

    /// Joins arcs to a ring. Each arc should begin at the last position of the previous arc.
    Result<void> read_ring(const Input& indices, Ring& ring) {
        return for_each(indices, "must be a list of indices of arcs", [&](const Input& index) -> Result<void> {
            const auto arc = find_arc(index);
            if (!arc) return tl::unexpected(arc.error());
            const auto [points, is_reversed] = *arc;
            if (!ring.empty() && !points.empty() && ring.back() == (is_reversed ? points.back() : points.front()))
                ring.pop_back();
            corners_ += points.size();
            if (corners_ > PolygonInput::kMaxCorners)
                return failure(
                    ErrorCode::LimitExceeded,
                    "the polygons have more than " + std::to_string(PolygonInput::kMaxCorners) + " corners, the limit",
                    indices.field);
            if (is_reversed) {
                ring.insert(ring.end(), points.rbegin(), points.rend());
            } else {
                ring.insert(ring.end(), points.begin(), points.end());
            }
            return {};
        });
    }

    /// @returns  the arc, and whether it is traversed backwards
    Result<std::pair<std::span<const Point>, bool>> find_arc(const Input& index) {
        const auto count = static_cast<double>(arcs_.size());
        const double given = json_of(index).is_number() ? json_of(index).number() : count;
        if (given != std::floor(given) || given < -count || given >= count)
            return malformed(index, "must be the index of one of " + std::to_string(arcs_.size()) +
                                        " arcs, or of a "
                                        "reversed one its ones' complement");
        const bool is_reversed = given < 0;
        const double position = is_reversed ? -1 - given : given;
        return arcs_.at(static_cast<std::size_t>(position)).map([&](std::span<const Point> points) {
            return std::pair(points, is_reversed);
        });
    }

    /// Calls read(element) for each element of an array, up to the first error.
    template <class Read>
    Result<void> for_each(const Input& list, std::string_view expected, Read read) {
        if (!json_of(list).is_array()) return malformed(list, expected);
        std::size_t index = 0;
        for (const JsonValue element : json_of(list)) {
            if (auto done = read(below(list, index++, element)); !done) return done;
        }
        return {};
    }

    Arcs arcs_;
    PolygonInput polygon_{{}, {}};
    std::size_t corners_ = 0;
};

std::string names_of(JsonValue objects) {
    std::vector<std::string> names;
    for (const auto& [name, value] : objects.members()) names.emplace_back(name);
    return join_names(names);
}

}  // namespace

bool is_topology(JsonValue value) {
    const auto type = value.is_object() ? value.find("type") : std::nullopt;
    return type && type->is_string() && type->text() == "Topology";
}

Result<Input> find_object(const Input& topology, const std::optional<std::string>& name) {
    const auto objects = require(topology, "objects");
    if (!objects) return tl::unexpected(objects.error());
    const JsonValue all = json_of(*objects);
    if (!all.is_object() || all.size() == 0) return malformed(*objects, "must be an object with members");
    if (!name && all.size() > 1)
        return malformed(*objects,
                         "has several members: choose one of them with the option object (" + names_of(all) + ")");
    if (!name) return require(*objects, all.members().front().name);
    if (all.find(*name)) return require(*objects, *name);
    return malformed(*objects, "has no member " + excerpt(*name) + ", only " + names_of(all));
}

Result<PolygonInput> read_topology(const Input& topology, const Input& object) {
    auto arcs = Arcs::create(topology);
    if (!arcs) return tl::unexpected(arcs.error());
    return Reader(*std::move(arcs)).execute(object);
}

}  // namespace ccdt::api
