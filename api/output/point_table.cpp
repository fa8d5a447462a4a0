// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/output/point_table.h"

#include <array>
#include <bit>
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

void write_npy_header(std::size_t rows, std::size_t columns, Body& body) {
    static_assert(std::endian::native == std::endian::little && sizeof(Point) == 2 * sizeof(double));
    const std::string header = npy_header("<f8", rows, columns);
    body.expect(header.size() + rows * columns * sizeof(double));
    body.text() += header;
}

/// Writes a row for each point.
/// @param rest  returns the columns after the first two
template <class Rest>
void write_rows(Body& body, std::span<const Point> points, std::size_t columns, Rest rest,
                const std::stop_token& stop) {
    write_records(points.size(), body, stop, [&](std::size_t i) {
        const auto [third, fourth, fifth] = rest(i);
        const std::array<double, 5> row = {points[i].x, points[i].y, third, fourth, fifth};
        body.text().append(reinterpret_cast<const char*>(row.data()), columns * sizeof(double));
    });
}

/// Returns the inks of the ground below a dot, as bits.
/// @param white  bits of the channels with white ground
unsigned inks_below(unsigned white, const Grounds& grounds) {
    return ~white & ((1U << grounds.inks.size()) - 1);
}

/// Joins the names of the inks whose bits are set. Returns "paper" if no bit is set.
std::string names_of(unsigned bits, const Grounds& grounds) {
    std::string names;
    for_channels(
        bits, [&](std::size_t channel) { names.append(names.empty() ? "" : "+").append(grounds.inks[channel].name); });
    return names.empty() ? "paper" : names;
}

/// Writes a line for each dot, with its radius and its side (ink or paper). With several channels, the flipped channels
/// and the inks of the ground replace the side.
void write_two_sides(const PointSet& kinds, Body& body, const std::stop_token& stop) {
    const bool named = kinds.are_named();
    std::string& out = body.text();
    out.append("x,y,radius,").append(named ? "flips,ground" : "side").append("\r\n");
    for (const InkDots& kind : kinds.layers) {
        const auto& dots = kind.two_sides->dots;
        const auto& grounds = kind.two_sides->grounds;
        write_records(dots.radii.size(), body, stop, [&](std::size_t i) {
            append_shortest(out, kind.dots.points[i].x);
            out += ',';
            append_shortest(out, kind.dots.points[i].y);
            out += ',';
            append_shortest(out, dots.radii[i]);
            if (named) {
                out.append(",")
                    .append(kind.ink.name)
                    .append(",")
                    .append(names_of(inks_below(dots.white[i], grounds), grounds));
            } else {
                out += dots.white[i] != 0 ? ",ink" : ",paper";
            }
            out += "\r\n";
        });
    }
}

/// Writes a row of an NPY file for each dot, with the columns of write_two_sides().
void write_two_sided_rows(const PointSet& kinds, Body& body, const std::stop_token& stop) {
    const bool named = kinds.are_named();
    const std::size_t columns = named ? 5 : 4;
    write_npy_header(kinds.size(), columns, body);
    for (const InkDots& kind : kinds.layers) {
        const auto& [dots, flips, grounds] = *kind.two_sides;
        const auto rest = [&, &dots = dots, &flips = flips, &grounds = grounds](std::size_t i) {
            const auto radius = static_cast<double>(dots.radii[i]);
            if (!named) return std::array{radius, dots.white[i] != 0 ? 0.0 : 1.0, 0.0};
            return std::array<double, 3>{radius, static_cast<double>(flips),
                                         static_cast<double>(inks_below(dots.white[i], grounds))};
        };
        write_rows(body, kind.dots.points, columns, rest, stop);
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
    if (points.layers.front().two_sides != nullptr) return write_two_sides(points, body, stop);
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
    if (points.layers.front().two_sides != nullptr) return write_two_sided_rows(points, body, stop);
    const bool ranked = points.are_ranked(), grouped = points.are_grouped(), named = points.are_named();
    const std::size_t columns = std::size_t{2} + ranked + grouped + named;
    write_npy_header(points.size(), columns, body);
    double number = 0;
    for (const InkDots& layer : points.layers) {
        const auto rest = [&](std::size_t i) {
            std::array<double, 3> row{};
            std::size_t column = 0;
            if (ranked) row[column++] = layer.dots.ranks[i];
            if (grouped) row[column++] = layer.features[i];
            row[column] = number;
            return row;
        };
        write_rows(body, layer.dots.points, columns, rest, stop);
        ++number;
    }
}

}  // namespace ccdt::api
