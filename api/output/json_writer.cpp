// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/output/json_writer.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include "api/json/json_document.h"
#include "api/output/json_pieces.h"
#include "api/text/numbers.h"

namespace ccdt::api {
namespace {

constexpr std::size_t kTypicalPointBytes = 41;  ///< `[x,y],`, where x and y have 17 digits

void append_point(std::string& out, Point point) {
    out += '[';
    append_number(out, point.x);
    out += ',';
    append_number(out, point.y);
    out += ']';
}

void write_points(Body& body, std::span<const Point> points, const std::stop_token& stop) {
    body.expect(body.text().size() + kTypicalPointBytes * points.size());
    write_list(body, points, append_point, stop);
}

void write_mesh(Body& body, const TriangleMesh& mesh, const std::stop_token& stop) {
    body.text() += ",\"vertices\":";
    write_points(body, mesh.vertices, stop);
    body.text() += ",\"triangles\":";
    write_list(body, std::span(mesh.triangles), append_indices, stop);
    body.text() += ",\"boundary\":";
    write_list(body, std::span(mesh.boundary), append_indices, stop);
}

void append_spectrum(std::string& out, const Spectrum& spectrum) {
    out += ",\"spectrum\":{\"values\":";
    append_numbers(out, spectrum.values);
    append_member(out, "width", static_cast<std::uint64_t>(spectrum.width));
    append_member(out, "height", static_cast<std::uint64_t>(spectrum.height));
    out += '}';
}

/// Appends the number of points, the seed and the method.
void append_order(std::string& out, std::size_t sites, const Report& report) {
    out += "\"sites\":";
    append_number(out, std::uint64_t{sites});
    append_member(out, "seed", report.seed);
    out.append(",\"method\":\"").append(report.method).append("\"");
}

/// Appends members that report an early stop, repairs, warnings, and the pitch on the globe.
void append_remarks(std::string& out, bool stopped, const Report& report) {
    if (stopped) out += ",\"partial\":true";
    if (!report.repairs.empty()) out.append(",\"repaired\":").append(write_repairs(report.repairs));
    if (!report.warnings.empty()) out.append(",\"warnings\":").append(write_warnings(report.warnings));
    if (report.pitch_m) append_member(out, "pitch_m", *report.pitch_m);
}

/// Appends members about the run that placed the points. Reports the largest values of all layers.
void append_run(std::string& out, const PointSet& points, const Report& report) {
    append_order(out, points.size(), report);
    std::uint64_t iterations = 0;
    double variation = points.layers.front().dots.variation();
    for (const InkDots& layer : points.layers) {
        iterations = std::max(iterations, static_cast<std::uint64_t>(layer.dots.iterations));
        variation = std::max(variation, layer.dots.variation());
    }
    append_member(out, "iterations", iterations);
    append_member(out, "variation", variation);
    append_remarks(out, points.are_partial(), report);
}

/// Writes repairs or warnings in printable ASCII: their texts may contain names from the request, and the result is
/// also sent in HTTP headers.
template <class Remark>
std::string write_remarks(std::span<const Remark> remarks) {
    std::string out;
    append_array(out, remarks, [](std::string& to, const Remark& remark) {
        to += "{\"pointer\":";
        append_ascii_json_text(to, remark.field);
        to += ",\"detail\":";
        append_ascii_json_text(to, remark.detail);
        to += '}';
    });
    return out;
}

/// Appends the computing time and, for halftones, the size of the picture and of the dots.
void append_report(std::string& out, const Report& report) {
    append_elapsed(out, report.elapsed_ms);
    if (!report.picture) return;
    append_member(out, "width", static_cast<std::uint64_t>(report.picture->width));
    append_member(out, "height", static_cast<std::uint64_t>(report.picture->height));
    if (!report.dots) return;
    append_member(out, "radius", report.dots->radius);
    append_member(out, "tone", report.dots->tone);
}

/// Rounds coordinates to a thousandth, which is precise enough for outlines.
Point rounded(Point point) {
    constexpr double kSteps = 1000;
    return {std::round(point.x * kSteps) / kSteps, std::round(point.y * kSteps) / kSteps};
}

void write_rings(Body& body, std::span<const std::vector<Point>> rings, const std::stop_token& stop) {
    const auto append_ring = [](std::string& out, const std::vector<Point>& ring) {
        append_array(out, ring, [](std::string& to, Point point) { append_point(to, rounded(point)); });
    };
    write_list(body, rings, append_ring, stop);
}

/// Writes the outlines of the inks of a drawing by one field.
void write_areas(Body& body, const InkAreas& areas, const std::stop_token& stop) {
    std::string& out = body.text();
    if (!areas.are_named()) {
        out += ",\"rings\":";
        return write_rings(body, areas.rings.front(), stop);
    }
    out += ",\"inks\":[";
    for (std::size_t i = 0; i < areas.inks.size(); ++i) {
        const Ink& ink = areas.inks[i];
        out.append(i > 0 ? "," : "").append("{\"name\":\"").append(ink.name).append("\",\"color\":\"");
        out.append(hexadecimal(ink.colour)).append("\",\"rings\":");
        write_rings(body, areas.rings[i], stop);
        out += '}';
    }
    out += ']';
}

/// Writes the members of an answer with a single ink.
void write_single_ink(Body& body, const PointSet& points, const Report& report, const std::stop_token& stop) {
    const auto& [ink, dots, radius, areas, features, path] = points.layers.front();
    std::string& out = body.text();
    out += "\"points\":";
    write_points(body, dots.points, stop);
    out += ',';
    append_run(out, points, report);
    out += ",\"trace\":";
    append_trace(out, dots.trace);
    append_report(out, report);
    write_ranks(body, dots.ranks, stop);
    if (dots.mesh) write_mesh(body, *dots.mesh, stop);
    if (areas != nullptr) write_areas(body, *areas, stop);
}

void write_ink(Body& body, const InkDots& each, const std::stop_token& stop) {
    const Ink& ink = each.ink;
    const Distribution& dots = each.dots;
    std::string& out = body.text();
    out.append("{\"name\":\"").append(ink.name).append("\",\"color\":\"").append(hexadecimal(ink.colour)).append("\"");
    append_member(out, "sites", std::uint64_t{dots.points.size()});
    append_member(out, "iterations", static_cast<std::uint64_t>(dots.iterations));
    append_member(out, "variation", dots.variation());
    out += ",\"trace\":";
    append_trace(out, dots.trace);
    out += ",\"points\":";
    write_points(body, dots.points, stop);
    out += '}';
}

/// Writes the members of an answer with named inks.
void write_inks(Body& body, const PointSet& points, const Report& report, const std::stop_token& stop) {
    std::string& out = body.text();
    out += "\"inks\":";
    append_array(out, points.layers, [&](std::string&, const InkDots& each) { write_ink(body, each, stop); });
    out += ',';
    append_order(out, points.size(), report);
    append_remarks(out, points.are_partial(), report);
    append_report(out, report);
}

/// Writes `"name":[...]` with an element for each point of all layers. Calls `append_element(out, layer, i)` for point
/// i of each layer. Ends early on a stop, or if the sink of the body fails.
template <class AppendElement>
void write_column(Body& body, std::string_view name, const PointSet& points, AppendElement append_element,
                  const std::stop_token& stop) {
    std::string& out = body.text();
    out.append("\"").append(name).append("\":[");
    std::size_t written = 0;
    for (const InkDots& layer : points.layers) {
        for (std::size_t i = 0; i < layer.dots.points.size(); ++i) {
            if (written % kJsonStopStride == 0 && (!body.flush() || stop.stop_requested())) return;
            if (written++ > 0) out += ',';
            append_element(out, layer, i);
        }
    }
    out += ']';
}

/// Returns the number of points of each class in each feature, as [classes][features].
std::vector<std::vector<std::uint64_t>> counts_of(const PointSet& points) {
    std::vector<std::vector<std::uint64_t>> counts;
    for (const InkDots& layer : points.layers) {
        counts.emplace_back(points.feature_ids.size(), 0);
        for (const std::uint32_t feature : layer.features) ++counts.back()[feature];
    }
    return counts;
}

/// Writes the features with their numbers of points. Ends early if the sink of the body fails.
void write_features(Body& body, const PointSet& points) {
    const auto counts = counts_of(points);
    std::size_t feature = 0;
    append_array(body.text(), points.feature_ids, [&](std::string& to, const std::string& id) {
        if (!body.flush()) return;
        to += '{';
        if (!id.empty()) to.append("\"id\":").append(id).append(",");
        std::uint64_t all = 0;
        for (const auto& of_class : counts) all += of_class[feature];
        to += "\"sites\":";
        append_number(to, all);
        if (points.are_named()) {
            to += ",\"classes\":";
            append_array(to, counts, [&](std::string& list, const auto& each) { append_number(list, each[feature]); });
        }
        if (points.properties != nullptr) {
            to += ",\"properties\":{";
            points.properties->append_members(to, feature);
            to += '}';
        }
        to += '}';
        ++feature;
    });
}

void append_classes(std::string& out, const PointSet& points) {
    append_array(out, points.layers, [](std::string& to, const InkDots& each) {
        to += "{\"name\":";
        append_json_text(to, each.ink.name);
        to.append(",\"color\":\"").append(hexadecimal(each.ink.colour)).append("\"");
        append_member(to, "sites", std::uint64_t{each.dots.points.size()});
        to += '}';
    });
}

/// Appends the properties that all points of a group share, each followed by a comma. First come the carried
/// properties, then the properties that identify the feature and the class. Appends nothing if points are not grouped.
void append_origin(std::string& out, const PointSet& points, const InkDots& layer, std::uint32_t feature) {
    if (!points.are_grouped()) return;
    if (points.properties != nullptr) {
        const std::size_t before = out.size();
        points.properties->append_members(out, feature);
        if (out.size() > before) out += ',';
    }
    out += "\"feature\":";
    append_number(out, std::uint64_t{feature});
    out += ',';
    if (!points.are_named()) return;
    out += "\"class\":";
    append_json_text(out, layer.ink.name);
    out.append(",\"color\":\"").append(hexadecimal(layer.ink.colour)).append("\",");
}

/// Writes the points of one class in one feature as a Feature.
/// @param first, count  range of these points in the layer
void write_feature(Body& body, const PointSet& points, const InkDots& layer, std::uint32_t feature, std::size_t first,
                   std::size_t count, const std::stop_token& stop) {
    std::string& out = body.text();
    out += R"({"type":"Feature")";
    if (!points.feature_ids[feature].empty()) out.append(",\"id\":").append(points.feature_ids[feature]);
    out += R"(,"properties":{)";
    append_origin(out, points, layer, feature);
    out += "\"sites\":";
    append_number(out, std::uint64_t{count});
    write_ranks(body, ranks_of(layer.dots, first, count), stop);
    out += R"(},"geometry":{"type":"MultiPoint","coordinates":)";
    write_list(body, std::span(layer.dots.points).subspan(first, count), append_point, stop);
    out += "}}";
}

/// Text before and after the Features of single points.
struct Separators {
    std::string_view before_first, before_others, after;
};

constexpr Separators kListed{"", ",\n", ""};
constexpr Separators kLines{"", "", "\n"};
constexpr Separators kSequence{"\x1e", "\x1e", "\n"};

/// Writes a Feature for each point. Ends early on a stop, or if the sink of the body fails.
/// @param ranks       ranks of the points; empty if there are none
/// @param properties  properties that all points share, each followed by a comma
/// @param is_first    whether these points are the first of the answer
void write_single_points(Body& body, std::span<const Point> points, std::span<const std::uint32_t> ranks,
                         std::string_view properties, const Separators& separators, bool is_first,
                         const std::stop_token& stop) {
    const std::size_t stride = flush_stride(properties.size());
    const std::string_view all = properties.substr(0, properties.size() - (ranks.empty() && !properties.empty()));
    std::string& out = body.text();
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (i % stride == 0 && (!body.flush() || stop.stop_requested())) break;
        out += is_first && i == 0 ? separators.before_first : separators.before_others;
        out.append(R"({"type":"Feature","properties":{)").append(all);
        if (!ranks.empty()) {
            out += "\"rank\":";
            append_index(out, ranks[i]);
        }
        out += R"(},"geometry":{"type":"Point","coordinates":)";
        append_point(out, points[i]);
        out.append("}}").append(separators.after);
    }
}

/// Writes a Feature for each point.
void write_single_points(Body& body, const PointSet& points, const Separators& separators,
                         const std::stop_token& stop) {
    bool first = true;
    for (const InkDots& layer : points.layers) {
        points.for_groups(layer, [&](std::uint32_t feature, std::size_t begin, std::size_t count) {
            std::string properties;
            append_origin(properties, points, layer, feature);
            if (points.are_grouped() && !points.feature_ids[feature].empty())
                properties.append("\"feature_id\":").append(points.feature_ids[feature]).append(",");
            write_single_points(body, std::span(layer.dots.points).subspan(begin, count),
                                ranks_of(layer.dots, begin, count), properties, separators, std::exchange(first, false),
                                stop);
        });
    }
}

/// Writes the members of an answer whose points are grouped by features.
void write_groups(Body& body, const PointSet& points, const Report& report, const std::stop_token& stop) {
    std::string& out = body.text();
    const auto index_of = [&](const InkDots& layer) { return std::uint64_t(&layer - points.layers.data()); };
    body.expect(kTypicalPointBytes * points.size());
    write_column(
        body, "points", points,
        [](std::string& to, const InkDots& layer, std::size_t i) { append_point(to, layer.dots.points[i]); }, stop);
    out += ',';
    if (points.are_ranked()) {
        write_column(
            body, "rank", points,
            [](std::string& to, const InkDots& layer, std::size_t i) { append_index(to, layer.dots.ranks[i]); }, stop);
        out += ',';
    }
    write_column(
        body, "feature", points,
        [](std::string& to, const InkDots& layer, std::size_t i) { append_index(to, layer.features[i]); }, stop);
    if (points.are_named()) {
        out += ',';
        write_column(
            body, "class", points,
            [&](std::string& to, const InkDots& layer, std::size_t) { append_number(to, index_of(layer)); }, stop);
        out += ",\"classes\":";
        append_classes(out, points);
    }
    out += ",\"features\":";
    write_features(body, points);
    out += ',';
    append_run(out, points, report);
    append_report(out, report);
}

/// Writes the points of a single layer as a Feature.
void write_feature(Body& body, const PointSet& points, const Report& report, const std::stop_token& stop) {
    const Distribution& dots = points.layers.front().dots;
    std::string& out = body.text();
    out += R"({"type":"Feature","properties":{)";
    append_run(out, points, report);
    write_ranks(body, dots.ranks, stop);
    out += R"(},"geometry":{"type":"MultiPoint","coordinates":)";
    write_points(body, dots.points, stop);
    out += "}}\n";
}

}  // namespace

std::string write_repairs(std::span<const Repair> repairs) {
    return write_remarks(repairs);
}

std::string write_warnings(std::span<const Warning> warnings) {
    return write_remarks(warnings);
}

void write_json(const PointSet& points, const Report& report, Body& body, const std::stop_token& stop) {
    const auto write_members = points.are_grouped() ? write_groups : points.are_named() ? write_inks : write_single_ink;
    body.text() += '{';
    write_members(body, points, report, stop);
    body.text() += "}\n";
}

void write_geojson(const PointSet& points, const Report& report, Body& body, const std::stop_token& stop) {
    if (!points.are_grouped()) return write_feature(body, points, report, stop);
    std::string& out = body.text();
    body.expect(kTypicalPointBytes * points.size());
    out += R"({"type":"FeatureCollection",)";
    append_run(out, points, report);
    out += ",\"features\":[";
    bool first = true;
    for (const InkDots& layer : points.layers) {
        points.for_groups(layer, [&](std::uint32_t feature, std::size_t begin, std::size_t count) {
            if (!std::exchange(first, false)) out += ",\n";
            write_feature(body, points, layer, feature, begin, count, stop);
        });
    }
    out += "]}\n";
}

void write_point_features(const PointSet& points, const Report& report, Body& body, const std::stop_token& stop) {
    body.text() += R"({"type":"FeatureCollection",)";
    append_run(body.text(), points, report);
    body.text() += ",\"features\":[";
    write_single_points(body, points, kListed, stop);
    body.text() += "]}\n";
}

void write_point_lines(const PointSet& points, const Report&, Body& body, const std::stop_token& stop) {
    write_single_points(body, points, kLines, stop);
}

void write_point_sequence(const PointSet& points, const Report&, Body& body, const std::stop_token& stop) {
    write_single_points(body, points, kSequence, stop);
}

std::string write_analysis(const Analysis& analysis, bool with_spectrum) {
    std::string out = "{\"frequency\":";
    append_numbers(out, analysis.frequency);
    out += ",\"power\":";
    append_numbers(out, analysis.power);
    out += ",\"anisotropy_db\":";
    append_numbers(out, analysis.anisotropy_db);
    append_member(out, "min_distance", analysis.min_distance);
    append_member(out, "mean_distance", analysis.mean_distance);
    append_low_frequency_power(out, analysis.low_frequency_power);
    append_member(out, "sets", std::uint64_t{analysis.sets});
    if (with_spectrum) append_spectrum(out, analysis.spectrum);
    out += "}\n";
    return out;
}

}  // namespace ccdt::api
