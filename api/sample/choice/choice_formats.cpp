// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/choice/choice_formats.h"

#include <bit>
#include <cstdint>
#include <utility>

#include "api/output/json_writer.h"
#include "api/output/npy_header.h"
#include "api/surface/ply.h"
#include "api/text/numbers.h"
#include "api/text/text.h"

namespace ccdt::api {
namespace {

bool has_height(const ChoiceRequest& request) {
    return request.extent != choice::Extent::Plane && !request.is_on_globe;
}

void append_position(std::string& out, const ChoiceRequest& request, std::uint32_t candidate) {
    const Point3 p = request.candidates[candidate];
    append_shortest(out, p.x);
    append_shortest(out += ',', p.y);
    if (has_height(request)) append_shortest(out += ',', p.z);
}

/// Calls function(candidate) for the chosen candidates, in order, and passes on what it wrote.
template <class Function>
void for_each(const ChosenCandidates& chosen, Body& body, Function&& function) {
    for (const std::uint32_t candidate : chosen.rows) {
        function(candidate);
        if (!body.flush()) return;
    }
}

void write_json(const ChoiceRequest& request, const ChosenCandidates& chosen, bool partial, Body& body) {
    constexpr std::size_t kMaxRegions = 100;
    std::string& out = body.text();
    const char* comma = "";
    std::size_t regions = 0;
    out += "{\"indices\":[";
    for_each(chosen, body, [&](std::uint32_t candidate) {
        out.append(std::exchange(comma, ",")).append(std::to_string(request.table.row_of(candidate)));
    });
    out += "],\"points\":[";
    comma = "";
    for_each(chosen, body, [&](std::uint32_t candidate) {
        append_position(out.append(std::exchange(comma, ",")) += '[', request, candidate);
        out += ']';
    });
    out += "],\"sites\":" + std::to_string(chosen.rows.size()) + ",\"seed\":" + std::to_string(request.seed) +
           ",\"shortfall\":" + std::to_string(chosen.shortfall) + ",\"shortfalls\":[";
    comma = "";
    for (const auto& [candidate, points] : chosen.shortfalls) {
        if (points < 1 || ++regions > kMaxRegions) break;
        out.append(std::exchange(comma, ","))
            .append("{\"index\":")
            .append(std::to_string(request.table.row_of(candidate)));
        append_rounded(out += ",\"sites\":", points, 1);
        out += '}';
    }
    out += ']';
    if (!request.warnings.empty()) out += ",\"warnings\":" + write_warnings(request.warnings);
    out += partial ? ",\"partial\":true}\n" : "}\n";
}

void write_csv(const ChoiceRequest& request, const ChosenCandidates& chosen, bool /*partial*/, Body& body) {
    std::string& out = body.text();
    out += has_height(request) ? "index,x,y,z\r\n" : "index,x,y\r\n";
    for_each(chosen, body, [&](std::uint32_t candidate) {
        append_position(out += std::to_string(request.table.row_of(candidate)) += ',', request, candidate);
        out += "\r\n";
    });
}

void write_npy(const ChoiceRequest& request, const ChosenCandidates& chosen, bool /*partial*/, Body& body) {
    static_assert(std::endian::native == std::endian::little);
    body.text() += npy_header("<u4", chosen.rows.size(), 1);
    for_each(chosen, body, [&](std::uint32_t candidate) {
        const std::uint32_t row = request.table.row_of(candidate);
        body.text().append(reinterpret_cast<const char*>(&row), sizeof(row));
    });
}

std::string_view record_of(const ChoiceRequest& request, std::uint32_t candidate) {
    return request.table.records[request.table.row_of(candidate)].in(request.file);
}

void write_csv_records(const ChoiceRequest& request, const ChosenCandidates& chosen, bool /*partial*/, Body& body) {
    body.text() += std::string_view(request.file).substr(0, request.table.body.begin);
    for_each(chosen, body, [&](std::uint32_t candidate) {
        const std::string_view record = record_of(request, candidate);
        body.text().append(record).append(record.ends_with('\n') ? "" : "\n");
    });
}

void write_features(const ChoiceRequest& request, const ChosenCandidates& chosen, bool /*partial*/, Body& body) {
    const std::string_view file = request.file;
    body.text() += file.substr(0, request.table.body.begin);
    const char* comma = "\n";
    for_each(chosen, body, [&](std::uint32_t candidate) {
        body.text().append(std::exchange(comma, ",\n")).append(record_of(request, candidate));
    });
    body.text().append("\n").append(file.substr(request.table.body.end));
}

template <bool kHasSeparators>
void write_sequence(const ChoiceRequest& request, const ChosenCandidates& chosen, bool /*partial*/, Body& body) {
    for_each(chosen, body, [&](std::uint32_t candidate) {
        if (kHasSeparators) body.text() += '\x1E';
        body.text().append(record_of(request, candidate)) += '\n';
    });
}

void write_vertices(const ChoiceRequest& request, const ChosenCandidates& chosen, bool /*partial*/, Body& body) {
    const auto header = read_ply_header(request.file).value();
    body.text() += ply_header_for(request.file, header, chosen.rows.size());
    const bool is_text = header.encoding == PlyHeader::Encoding::Text;
    for_each(chosen, body, [&](std::uint32_t candidate) {
        const std::string_view record = record_of(request, candidate);
        body.text() += is_text ? std::string(trim(record, " \t\r\n")) + '\n' : std::string(record);
    });
}

constexpr ChoiceFormat kJsonChoice{kJson, 80, false, write_json};
constexpr ChoiceFormat kCsvChoice{kCsv, 80, false, write_csv};
constexpr ChoiceFormat kNpyChoice{kNpy, 4, false, write_npy};
constexpr ChoiceFormat kCsvRecords{kCsv, 0, true, write_csv_records};
constexpr ChoiceFormat kFeatures{kGeoJson, 0, true, write_features};
constexpr ChoiceFormat kFeatureLines{kGeoJsonLines, 0, true, write_sequence<false>};
constexpr ChoiceFormat kFeatureSequence{kGeoJsonSequence, 0, true, write_sequence<true>};
constexpr ChoiceFormat kVertices{kPly, 0, true, write_vertices};

constexpr const ChoiceFormat* kOfJson[] = {&kJsonChoice, &kCsvChoice, &kNpyChoice};
constexpr const ChoiceFormat* kOfNpy[] = {&kNpyChoice, &kJsonChoice, &kCsvChoice};
constexpr const ChoiceFormat* kOfCsv[] = {&kCsvRecords, &kJsonChoice, &kNpyChoice};
constexpr const ChoiceFormat* kOfGeoJson[] = {&kFeatures, &kJsonChoice, &kCsvChoice, &kNpyChoice};
constexpr const ChoiceFormat* kOfLines[] = {&kFeatureLines, &kJsonChoice, &kCsvChoice, &kNpyChoice};
constexpr const ChoiceFormat* kOfSequence[] = {&kFeatureSequence, &kJsonChoice, &kCsvChoice, &kNpyChoice};
constexpr const ChoiceFormat* kOfPly[] = {&kVertices, &kJsonChoice, &kCsvChoice, &kNpyChoice};
constexpr const ChoiceFormat* kAll[] = {&kJsonChoice,   &kCsvChoice,       &kNpyChoice, &kFeatures,
                                        &kFeatureLines, &kFeatureSequence, &kVertices};

}  // namespace

std::span<const ChoiceFormat* const> choice_formats() {
    return kAll;
}

std::span<const ChoiceFormat* const> choice_formats(std::optional<PointFileKind> kind) {
    switch (kind.value_or(PointFileKind::Json)) {
        case PointFileKind::Csv:
            return kOfCsv;
        case PointFileKind::Npy:
            return kOfNpy;
        case PointFileKind::Ply:
            return kOfPly;
        case PointFileKind::GeoJson:
            return kOfGeoJson;
        case PointFileKind::JsonLines:
            return kOfLines;
        case PointFileKind::JsonSequence:
            return kOfSequence;
        case PointFileKind::Json:
            break;
    }
    return kOfJson;
}

}  // namespace ccdt::api
