// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/output/point_table.h"

#include <cstddef>
#include <string_view>

#include "api/output/npy_header.h"
#include "api/output/records.h"
#include "api/text/numbers.h"

namespace ccdt::api {
namespace {

constexpr std::size_t kTypicalLineBytes = 40;  ///< two numbers with 18 characters each, a comma and a line break
constexpr std::size_t kTypicalNameBytes = 8;   ///< usual number of bytes of an ink's name and a comma

/// @param ranks  ranks of the points; may be empty
/// @param end    text after the point and its rank: the remaining columns and the end of the line
void write_lines(Body& body, std::span<const Point> points, std::span<const std::uint32_t> ranks, std::string_view end,
                 const std::stop_token& stop) {
    std::string& out = body.text();
    const std::size_t stride = flush_stride(end.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (i % stride == 0 && (!body.flush() || stop.stop_requested())) break;
        append_shortest(out, points[i].x);
        out += ',';
        append_shortest(out, points[i].y);
        if (!ranks.empty()) out.append(",").append(std::to_string(ranks[i]));
        out += end;
    }
}

/// Quotes a field that contains a separator or a quote (RFC 4180).
std::string quoted(std::string_view text) {
    if (text.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(text);
    std::string out = "\"";
    for (const char c : text) out.append(c == '"' ? 2 : 1, c);
    return out + '"';
}

/// Appends the columns of a feature's properties: text as it is, other values as JSON. A null or missing property gives
/// an empty field.
void append_columns(std::string& out, const CarriedProperties& properties, std::size_t feature) {
    std::size_t column = 0;
    for (const auto& [name, is_text, value] : properties.of_feature[feature]) {
        out.append(name + 1 - column, ',');
        column = name + 1;
        if (is_text || value != "null") out += quoted(value);
    }
    out.append(properties.names.size() - column, ',');
}

}  // namespace

void write_csv(const PointSet& points, Body& body, const std::stop_token& stop) {
    const bool named = points.are_named(), grouped = points.are_grouped();
    const auto* const properties = points.properties;
    body.expect((points.size() + 1) * (kTypicalLineBytes + (named || grouped ? kTypicalNameBytes : 0)));
    std::string& out = body.text();
    out.append("x,y").append(points.are_ranked() ? ",rank" : "").append(grouped ? ",feature" : "");
    if (named) out += grouped ? ",class" : ",ink";
    if (properties != nullptr) {
        for (const std::string& name : properties->names) out.append(",").append(quoted(name));
    }
    out += "\r\n";
    for (const InkDots& layer : points.layers) {
        points.for_groups(layer, [&](std::uint32_t feature, std::size_t first, std::size_t count) {
            std::string end;
            if (grouped) end.append(",").append(std::to_string(feature));
            if (named) end.append(",").append(quoted(layer.ink.name));
            if (properties != nullptr) append_columns(end, *properties, feature);
            end += "\r\n";
            write_lines(body, std::span(layer.dots.points).subspan(first, count), ranks_of(layer.dots, first, count),
                        end, stop);
        });
    }
}

void write_npy(const PointSet& points, Body& body, const std::stop_token& stop) {
    const bool ranked = points.are_ranked(), grouped = points.are_grouped(), named = points.are_named();
    const std::size_t columns = std::size_t{2} + ranked + grouped + named;
    std::string& out = body.text();
    out += npy_header("<f8", points.size(), columns);
    body.expect(out.size() + points.size() * columns * sizeof(double));
    double number = 0;
    for (const InkDots& layer : points.layers) {
        write_records(layer.dots.points.size(), body, stop, [&](std::size_t i) {
            append_binary(out, layer.dots.points[i]);
            if (ranked) append_binary(out, static_cast<double>(layer.dots.ranks[i]));
            if (grouped) append_binary(out, static_cast<double>(layer.features[i]));
            if (named) append_binary(out, number);
        });
        ++number;
    }
}

}  // namespace ccdt::api
