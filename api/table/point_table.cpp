// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/table/point_table.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <utility>

#include "api/image/image_header.h"
#include "api/input/npy_reader.h"
#include "api/input/option_reader.h"
#include "api/input/point_reader.h"
#include "api/json/json_document.h"
#include "api/surface/ply.h"
#include "api/table/csv_reader.h"
#include "api/text/byte_order_mark.h"
#include "api/text/file_kind.h"
#include "api/text/numbers.h"
#include "api/text/text.h"
#include "core/geometry/axes.h"

namespace ccdt::api {
namespace {

constexpr std::string_view kAxisNames = "xyz";
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Characters before the first value of JSON, also of a sequence of texts (RFC 8142).
constexpr std::string_view kBlanks = " \t\r\n\x1E";

/// Names of columns with longitudes and latitudes, in small letters. The last ones are those of Darwin Core.
constexpr std::array<std::array<std::string_view, 5>, 2> kDegrees = {
    {{"lon", "lng", "long", "longitude", "decimallongitude"}, {"lat", "latitude", "decimallatitude", {}, {}}}};

tl::unexpected<Error> wrong(std::string message) {
    return failure(ErrorCode::Malformed, std::move(message));
}

tl::unexpected<Error> too_many(const Limits& limits) {
    return failure(ErrorCode::LimitExceeded,
                   "there are more points than this server's limit (max-sites), " + std::to_string(limits.max_sites));
}

tl::unexpected<Error> no_column(std::string_view name, std::span<const std::string> known) {
    return failure(ErrorCode::Malformed,
                   "there is no column '" + excerpt(name) + "'; the columns are " + join_names(known),
                   std::string(name));
}

/// Collects points in a table.
class TableBuilder {
public:
    TableBuilder(PointTable& table, const PointColumns& columns, const Limits& limits)
        : table_(table), columns_(columns), limits_(limits) {
        table_.columns.resize(columns.names.size());
    }

    /// Adds a record.
    /// @param place   of the record, for messages: function()
    /// @param values  [names] numbers of the record
    /// @param label   ignored unless labels are asked for
    template <class Place>
    Result<void> add(Point3 position, std::span<const double> values, std::string_view label, Place&& place) {
        if (records_++ == limits_.max_sites) return too_many(limits_);
        const auto row = static_cast<std::uint32_t>(records_ - 1);
        bool lacks_all = true;
        std::optional<std::size_t> lacking;
        for (std::size_t axis = 0; axis < table_.dimensions; ++axis) {
            const bool is_number = std::isfinite(along(position, axis));
            lacks_all &= std::isnan(along(position, axis));
            if (!is_number && !lacking) lacking = axis;
        }
        if (lacks_all && columns_.by_record) {
            leave_out();
            return {};
        }
        if (lacking) return wrong(place(*lacking));
        if (table_.left_out > 0) table_.rows.push_back(row);
        table_.positions.push_back(position);
        for (std::size_t name = 0; name < values.size(); ++name) table_.columns[name].push_back(values[name]);
        if (!columns_.label.empty()) table_.labels.add(label);
        return {};
    }

    void leave_out() {
        for (std::uint32_t row = 0; table_.left_out == 0 && row < table_.positions.size(); ++row)
            table_.rows.push_back(row);
        ++table_.left_out;
    }

private:
    PointTable& table_;
    const PointColumns& columns_;
    const Limits& limits_;
    std::size_t records_ = 0;
};

/// Columns of CSV with what is asked for.
struct CsvColumns {
    std::vector<std::size_t> axes, names;
    std::optional<std::size_t> label;
    bool is_lonlat = false;
};

std::optional<std::size_t> index_of(std::span<const std::string> header, std::string_view name) {
    const auto found = std::ranges::find(header, name);
    if (found == header.end()) return std::nullopt;
    return static_cast<std::size_t>(found - header.begin());
}

std::optional<std::size_t> index_of_degrees(std::span<const std::string> header, std::size_t axis) {
    for (std::size_t i = 0; i < header.size(); ++i) {
        const std::string name = in_small_letters(header[i]);
        if (!name.empty() && std::ranges::find(kDegrees[axis], name) != kDegrees[axis].end()) return i;
    }
    return std::nullopt;
}

Result<CsvColumns> find_columns(std::span<const std::string> header, const PointColumns& columns) {
    CsvColumns found;
    const auto of_axis = [&](std::size_t axis) {
        const std::string& given = columns.axes[axis];
        return index_of(header, given.empty() ? kAxisNames.substr(axis, 1) : std::string_view(given));
    };
    const bool is_named = !columns.axes[0].empty() || !columns.axes[1].empty();
    const auto x = of_axis(0), y = of_axis(1), z = of_axis(2);
    const auto longitude = index_of_degrees(header, 0), latitude = index_of_degrees(header, 1);
    found.is_lonlat = columns.by_record && !is_named && (!x || !y) && longitude && latitude;
    for (std::size_t axis = 0; axis < columns.axes.size(); ++axis) {
        if (!columns.axes[axis].empty() && !of_axis(axis)) return no_column(columns.axes[axis], header);
    }
    if (found.is_lonlat) {
        found.axes = {*longitude, *latitude};
    } else {
        if (x && y) found.axes = {*x, *y};
        if (x && y && z && columns.dimensions != 2) found.axes.push_back(*z);
    }
    if (found.axes.size() < std::max(columns.dimensions, std::size_t{2}))
        return wrong("line 1 must name the columns, with " +
                     std::string(columns.dimensions == 3 ? "x, y and z" : "x and y") + " among them");
    for (const std::string& name : columns.names) {
        const auto index = index_of(header, name);
        if (!index) return no_column(name, header);
        found.names.push_back(*index);
    }
    found.label = index_of(header, columns.label);
    if (!columns.label.empty() && !found.label) return no_column(columns.label, header);
    return found;
}

std::string text_of(double number) {
    std::string text;
    append_shortest(text, number);
    return text;
}

/// Reads a field of CSV: NaN if it is not a number.
double number_of(std::string_view field) {
    const std::string_view text = trim(field);
    if (const auto number = parse_number<double>(text)) return *number;
    const std::string word = in_small_letters(text);
    return word == "true" ? 1 : word == "false" ? 0 : kNone;
}

Result<void> read_csv(std::string_view text, const PointColumns& columns, const Limits& limits, PointTable& table) {
    CsvReader reader(text, CsvReader::find_separator(text));
    if (auto header = reader.next(); !header) return tl::unexpected(std::move(header.error()));
    const std::vector<std::string> header = reader.fields();
    const auto found = find_columns(header, columns);
    if (!found) return tl::unexpected(found.error());
    table.dimensions = found->axes.size();
    table.is_lonlat = found->is_lonlat;
    TableBuilder builder(table, columns, limits);
    table.body = {reader.offset(), text.size()};
    std::vector<double> values(found->names.size());
    for (std::size_t begin = reader.offset();; begin = reader.offset()) {
        const auto more = reader.next();
        if (!more) return tl::unexpected(more.error());
        if (!*more) return {};
        const auto& fields = reader.fields();
        if (fields.size() != header.size())
            return wrong(reader.position() + " has " + std::to_string(fields.size()) + " columns; the first line has " +
                         std::to_string(header.size()));
        Point3 position{};
        for (std::size_t axis = 0; axis < found->axes.size(); ++axis) {
            const std::string& field = fields[found->axes[axis]];
            along(position, axis) = number_of(field);
            // Other words are mistakes.
            const bool is_missing = columns.by_record && (trim(field).empty() || trim(field) == "NA");
            if (std::isnan(along(position, axis)) && !is_missing)
                along(position, axis) = std::numeric_limits<double>::infinity();
        }
        for (std::size_t name = 0; name < values.size(); ++name) values[name] = number_of(fields[found->names[name]]);
        const std::string_view label = found->label ? std::string_view(fields[*found->label]) : "";
        auto added = builder.add(position, values, label, [&](std::size_t axis) {
            const std::size_t column = found->axes[axis];
            return reader.position() + ": " + header[column] + " must be a finite number, not '" +
                   excerpt(fields[column]) + "'";
        });
        if (!added) return added;
        table.records.push_back({begin, reader.offset()});
    }
}

Result<void> read_array(std::string_view file, const PointColumns& columns, const Limits& limits, PointTable& table) {
    const auto array = read_npy(file);
    if (!array) return tl::unexpected(array.error());
    const auto& shape = array->shape;
    const std::size_t least = std::max(columns.dimensions, std::size_t{2});
    if (!array->has_numbers() || shape.size() != 2 || shape[1] < least)
        return wrong("the NPY file must be an array of numbers, with a row for each point and at least " +
                     std::string(least == 2 ? "two" : "three") + " columns");
    if (shape[0] > limits.max_sites) return too_many(limits);
    table.dimensions = columns.dimensions > 0 ? columns.dimensions : std::min(shape[1], std::size_t{3});
    std::vector<std::size_t> sources;
    const auto find = [&](std::string_view name) -> Result<void> {
        const auto number = parse_number<std::size_t>(name);
        if (!number || *number >= shape[1])
            return failure(ErrorCode::Malformed,
                           "columns of NPY are numbers from 0 to " + std::to_string(shape[1] - 1) + ", not '" +
                               excerpt(name) + "'",
                           std::string(name));
        sources.push_back(*number);
        return {};
    };
    for (std::size_t axis = 0; axis < table.dimensions; ++axis) {
        const std::string& name = columns.axes[axis];
        if (auto right = find(name.empty() ? std::to_string(axis) : name); !right) return right;
    }
    for (const std::string& name : columns.names) {
        if (auto right = find(name); !right) return right;
    }
    if (!columns.label.empty()) {
        if (auto right = find(columns.label); !right) return right;
    }
    TableBuilder builder(table, columns, limits);
    std::vector<double> values(columns.names.size());
    for (std::size_t i = 0; i < shape[0]; ++i) {
        const auto value = [&](std::size_t source) { return array->value(i * shape[1] + sources[source]); };
        Point3 position{};
        for (std::size_t axis = 0; axis < table.dimensions; ++axis) along(position, axis) = value(axis);
        for (std::size_t name = 0; name < values.size(); ++name) values[name] = value(table.dimensions + name);
        const std::string label = columns.label.empty() ? "" : text_of(value(sources.size() - 1));
        auto added = builder.add(position, values, label, [i](std::size_t) {
            return "row " + std::to_string(i) + " of the NPY file is not finite";
        });
        if (!added) return added;
    }
    return {};
}

/// Reads the vertices of a PLY.
Result<void> read_ply(std::string_view file, const PointColumns& columns, const Limits& limits, PointTable& table) {
    const auto header = read_ply_header(file);
    if (!header) return wrong(header.error().message);
    if (header->count("vertex") > limits.max_sites) return too_many(limits);
    std::vector<std::string> known;
    for (const PlyElement& element : header->elements) {
        if (element.name != "vertex") continue;
        for (const PlyProperty& property : element.properties) {
            if (!property.is_list) known.emplace_back(property.name);
        }
    }
    const bool has_z = columns.dimensions == 3 || !columns.axes[2].empty() || index_of(known, "z");
    table.dimensions = columns.dimensions > 0 ? columns.dimensions : has_z ? 3 : 2;
    std::vector<std::string_view> names;
    for (std::size_t axis = 0; axis < table.dimensions; ++axis)
        names.push_back(columns.axes[axis].empty() ? kAxisNames.substr(axis, 1) : std::string_view(columns.axes[axis]));
    for (const std::string& name : columns.names) names.emplace_back(name);
    if (!columns.label.empty()) names.emplace_back(columns.label);
    for (std::size_t i = 0; i < names.size(); ++i) {
        const bool is_given = i >= table.dimensions || !columns.axes[i].empty();
        if (is_given && !index_of(known, names[i])) return no_column(names[i], known);
    }
    const auto rows = read_ply_rows(file, names);
    if (!rows) return wrong(rows.error().message);
    TableBuilder builder(table, columns, limits);
    std::vector<double> values(columns.names.size());
    for (std::size_t i = 0; i + 1 < rows->ends.size(); ++i) {
        Point3 position{};
        for (std::size_t axis = 0; axis < table.dimensions; ++axis) along(position, axis) = rows->columns[axis][i];
        for (std::size_t name = 0; name < values.size(); ++name)
            values[name] = rows->columns[table.dimensions + name][i];
        const std::string label = columns.label.empty() ? "" : text_of(rows->columns.back()[i]);
        auto added = builder.add(position, values, label, [&](std::size_t axis) {
            return "vertex " + std::to_string(i) + " of the PLY has no finite " + std::string(names[axis]);
        });
        if (!added) return added;
        table.records.push_back({rows->ends[i], rows->ends[i + 1]});
    }
    if (!rows->ends.empty()) table.body = {rows->ends.front(), rows->ends.back()};
    return {};
}

/// Reads a list of positions, or a geometry.
Result<void> read_list(JsonValue root, const PointColumns& columns, const Limits& limits, PointTable& table) {
    const auto member = root.is_object() ? root.find("points") : std::nullopt;
    const Input input = member ? Input{"/points", "/points", *member} : Input{"the file", "", root};
    const JsonValue list = member.value_or(root);
    const bool has_height =
        list.is_array() && list.size() > 0 && (*list.begin()).is_array() && (*list.begin()).size() == 3;
    table.dimensions = columns.dimensions > 0 ? columns.dimensions : has_height ? 3 : 2;
    for (const std::string& name : columns.names) return no_column(name, {});
    if (!columns.label.empty()) return no_column(columns.label, {});
    if (table.dimensions == 3) return assign(table.positions, read_points3(input, limits));
    const auto points = read_points(input, limits);
    if (!points) return tl::unexpected(points.error());
    for (const Point p : *points) table.positions.push_back({p.x, p.y, 0});
    return {};
}

std::optional<JsonValue> property_of(JsonValue feature, std::string_view name) {
    const auto properties = feature.is_object() ? feature.find("properties") : std::nullopt;
    return properties && properties->is_object() ? properties->find(name) : std::nullopt;
}

/// Returns the value of a property: NaN if it is not a number.
double number_of(std::optional<JsonValue> value) {
    if (value && value->is_boolean()) return value->boolean() ? 1 : 0;
    return value && value->is_number() ? value->number() : kNone;
}

Result<void> read_feature(JsonValue feature, std::string_view pointer, const PointColumns& columns,
                          const Limits& limits, TableBuilder& builder) {
    const auto geometry = feature.is_object() ? feature.find("geometry") : std::nullopt;
    Point3 position{kNone, kNone, 0};
    if (!geometry || !geometry->is_null()) {
        const auto points = read_points({std::string(pointer), std::string(pointer), feature}, limits);
        if (!points) return tl::unexpected(points.error());
        if (points->size() != 1)
            return wrong(std::string(pointer) + " must have a single point, not " + std::to_string(points->size()));
        position = {points->front().x, points->front().y, 0};
    }
    std::vector<double> values;
    for (const std::string& name : columns.names) values.push_back(number_of(property_of(feature, name)));
    const auto label = property_of(feature, columns.label);
    return builder.add(position, values, label ? label_of(*label) : "",
                       [pointer](std::size_t) { return std::string(pointer) + " has no geometry"; });
}

Result<void> read_features(std::string_view file, const FeatureTexts& texts, const PointColumns& columns,
                           const Limits& limits, PointTable& table) {
    if (texts.list) {
        const std::string frame(file.substr(0, texts.list->begin));
        const auto document = JsonDocument::parse_features(frame + std::string(file.substr(texts.list->end)));
        if (!document) return tl::unexpected(document.error());
    }
    TableBuilder builder(table, columns, limits);
    for (const TextRange& each : texts.features) {
        const auto document = JsonDocument::parse(each.in(file));
        const std::string pointer = pointer_below("/features", table.records.size());
        if (!document) {
            const auto whole = JsonDocument::parse_features(file);  // tells the position of the error in the file
            return whole ? wrong(pointer + ": " + document.error().message) : tl::unexpected(whole.error());
        }
        if (auto read = read_feature(document->root(), pointer, columns, limits, builder); !read) return read;
        table.records.push_back(each);
    }
    for (std::size_t name = 0; name < columns.names.size(); ++name) {
        if (!table.positions.empty() &&
            std::ranges::all_of(table.columns[name], [](double v) { return std::isnan(v); }))
            return failure(ErrorCode::Malformed,
                           "no feature has a number in its property '" + excerpt(columns.names[name]) + "'",
                           columns.names[name]);
    }
    if (texts.list) table.body = *texts.list;
    return {};
}

Result<void> read_json(std::string_view file, const PointColumns& columns, const Limits& limits, PointTable& table) {
    const auto texts = columns.by_record ? find_features(file) : std::nullopt;
    const bool is_geometry =
        texts && !texts->list && texts->features.size() == 1 && file.find("\"Feature\"") == std::string_view::npos;
    if (texts && !is_geometry) {
        const bool has_separators = trim(without_byte_order_mark(file), " \t\r\n").starts_with('\x1E');
        table.kind = texts->list      ? PointFileKind::GeoJson
                     : has_separators ? PointFileKind::JsonSequence
                                      : PointFileKind::JsonLines;
        return read_features(file, *texts, columns, limits, table);
    }
    table.kind = PointFileKind::Json;
    const auto document = JsonDocument::parse_features(file);
    if (!document) return tl::unexpected(document.error());
    auto read = read_list(document->root(), columns, limits, table);
    if (!read && read.error().field.starts_with('/')) read.error().field.clear();
    return read;
}

}  // namespace

void Labels::add(std::string_view name) {
    auto found = numbers_.find(name);
    if (found == numbers_.end()) {
        found = numbers_.emplace(name, static_cast<std::uint32_t>(names.size())).first;
        names.emplace_back(name);
    }
    number.push_back(found->second);
}

std::string label_of(JsonValue value) {
    std::string text;
    if (value.is_string()) return value.text();
    if (!value.is_null()) append_json(text, value);
    return text;
}

std::string PointTable::place_of(std::size_t position, std::string_view file) const {
    const std::uint32_t row = row_of(position);
    switch (kind) {
        case PointFileKind::Csv:
            return "line " + std::to_string(1 + std::ranges::count(file.substr(0, records[row].begin), '\n'));
        case PointFileKind::Ply:
            return "vertex " + std::to_string(row);
        case PointFileKind::Npy:
            return "row " + std::to_string(row);
        default:
            return pointer_below("/features", row);
    }
}

Result<PointTable> read_point_table(std::string_view file, const PointColumns& columns, const Limits& limits) {
    PointTable table;
    const std::string_view content = without_byte_order_mark(file);
    const std::size_t mark = file.size() - content.size();
    Result<void> read;
    if (is_npy(content)) {
        table.kind = PointFileKind::Npy;
        read = read_array(content, columns, limits, table);
    } else if (is_ply(content)) {
        table.kind = PointFileKind::Ply;
        read = read_ply(content, columns, limits, table);
    } else if (begins_like_json(content, kBlanks)) {
        read = read_json(content, columns, limits, table);
    } else {
        const std::string_view kind = recognise_image(content) ? "a picture" : kind_of_file(content);
        if (kind != "CSV" && kind != "text" && !kind.empty())
            return wrong("the file " + std::string(kind == "empty" ? "is " : "seems to be ") + std::string(kind) +
                         "; points are read from CSV, JSON, NPY and PLY");
        read = read_csv(content, columns, limits, table);
    }
    if (!read) return tl::unexpected(read.error());
    table.body = {table.body.begin + mark, table.body.end + mark};
    for (TextRange& record : table.records) record = {record.begin + mark, record.end + mark};
    return table;
}

}  // namespace ccdt::api
