// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/analyze/point_file_reader.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <string>
#include <utility>

#include "api/image/image_header.h"
#include "api/input/npy_reader.h"
#include "api/input/option_reader.h"
#include "api/input/point_reader.h"
#include "api/json/json_document.h"
#include "api/surface/ply.h"
#include "api/text/byte_order_mark.h"
#include "api/text/file_kind.h"
#include "api/text/text.h"
#include "core/geometry/axes.h"

namespace ccdt::api {
namespace {

/// Characters before the first value of JSON, also of a sequence of texts (RFC 8142).
constexpr std::string_view kBlanks = " \t\r\n\x1E";

tl::unexpected<Error> wrong(std::string message) {
    return failure(ErrorCode::Malformed, std::move(message));
}

tl::unexpected<Error> too_many(const Limits& limits) {
    return failure(ErrorCode::LimitExceeded,
                   "there are more points than this server's limit (max-sites), " + std::to_string(limits.max_sites));
}

/// Splits CSV into records of fields.
class CsvReader {
public:
    explicit CsvReader(std::string_view text) : rest_(text) {}

    /// Reads the next record, which may contain line breaks in quoted fields. Returns false at the end of the text.
    /// Errors: Malformed.
    Result<bool> next() {
        fields_.clear();
        line_ = next_line_;
        if (rest_.empty()) return false;
        while (true) {
            if (auto read = read_field(); !read) return tl::unexpected(std::move(read.error()));
            if (rest_.empty()) return true;
            const char separator = rest_.front();
            rest_.remove_prefix(1);
            if (separator == ',') continue;
            ++next_line_;
            return true;
        }
    }

    const std::vector<std::string>& fields() const { return fields_; }

    /// Returns the beginning of messages about the current record.
    std::string position() const { return "line " + std::to_string(line_); }

private:
    /// Reads a field up to the comma or the line break after it.
    Result<void> read_field() {
        std::string& field = fields_.emplace_back();
        if (!rest_.starts_with('"')) {
            field = rest_.substr(0, rest_.find_first_of(",\n"));
            rest_.remove_prefix(field.size());
            if (field.ends_with('\r')) field.pop_back();
            return {};
        }
        rest_.remove_prefix(1);
        while (true) {
            const auto quote = rest_.find('"');
            if (quote == std::string_view::npos) return wrong(position() + ": a quoted field has no end");
            field += rest_.substr(0, quote);
            rest_.remove_prefix(quote + 1);
            if (!rest_.starts_with('"')) break;
            field += '"';
            rest_.remove_prefix(1);
        }
        next_line_ += static_cast<std::size_t>(std::ranges::count(field, '\n'));
        if (rest_.starts_with("\r\n")) rest_.remove_prefix(1);
        if (rest_.empty() || rest_.front() == ',' || rest_.front() == '\n') return {};
        return wrong(position() + ": there is text after a quoted field");
    }

    std::string_view rest_;
    std::vector<std::string> fields_;
    std::size_t line_ = 0;
    std::size_t next_line_ = 1;
};

/// A column of coordinates in CSV.
struct Column {
    std::string_view name;
    std::size_t index = 0;
};

/// Finds the columns of the coordinates.
template <std::size_t kCount>
Result<std::array<Column, kCount>> find_columns(const CsvReader& header) {
    std::array<Column, kCount> columns;
    for (std::size_t axis = 0; axis < kCount; ++axis) {
        const auto& names = header.fields();
        const std::string_view name = std::string_view("xyz").substr(axis, 1);
        const auto found = std::ranges::find(names, name);
        if (found == names.end())
            return wrong("line 1 must name the columns, with " + std::string(kCount == 2 ? "x and y" : "x, y and z") +
                         " among them");
        columns[axis] = {name, static_cast<std::size_t>(found - names.begin())};
    }
    return columns;
}

Result<double> read_ordinate(const CsvReader& reader, Column column) {
    const std::string& text = reader.fields()[column.index];
    const auto number = parse_number<double>(text);
    if (!number || !std::isfinite(*number))
        return wrong(reader.position() + ": " + std::string(column.name) + " must be a finite number, not '" +
                     excerpt(text) + "'");
    return *number;
}

template <class P>
Result<std::vector<P>> read_csv(std::string_view text, const Limits& limits) {
    CsvReader reader(text);
    if (auto header = reader.next(); !header) return tl::unexpected(std::move(header.error()));
    const auto columns = find_columns<kAxes<P>>(reader);
    if (!columns) return tl::unexpected(columns.error());
    const std::size_t count = reader.fields().size();
    std::vector<P> points;
    while (true) {
        const auto more = reader.next();
        if (!more) return tl::unexpected(more.error());
        if (!*more) return points;
        if (reader.fields().size() != count)
            return wrong(reader.position() + " has " + std::to_string(reader.fields().size()) +
                         " columns; the first line has " + std::to_string(count));
        std::array<double, kAxes<P>> ordinates{};
        for (std::size_t axis = 0; axis < ordinates.size(); ++axis) {
            const auto ordinate = read_ordinate(reader, (*columns)[axis]);
            if (!ordinate) return tl::unexpected(ordinate.error());
            ordinates[axis] = *ordinate;
        }
        if (points.size() == limits.max_sites) return too_many(limits);
        points.push_back(std::bit_cast<P>(ordinates));
    }
}

template <class P>
Result<std::vector<P>> read_array(std::string_view file, const Limits& limits) {
    const auto array = read_npy(file);
    if (!array) return tl::unexpected(array.error());
    const auto& shape = array->shape;
    if (!array->has_numbers() || shape.size() != 2 || shape[1] < kAxes<P>)
        return wrong("the NPY file must be an array of numbers, with a row for each point and at least " +
                     std::string(kAxes<P> == 2 ? "two" : "three") + " columns");
    if (shape[0] > limits.max_sites) return too_many(limits);
    std::vector<P> points(shape[0]);
    for (std::size_t i = 0; i < points.size(); ++i) {
        std::array<double, kAxes<P>> ordinates;
        for (std::size_t axis = 0; axis < ordinates.size(); ++axis) ordinates[axis] = array->value(i * shape[1] + axis);
        if (!std::ranges::all_of(ordinates, [](double value) { return std::isfinite(value); }))
            return wrong("row " + std::to_string(i) + " of the NPY file is not finite");
        points[i] = std::bit_cast<P>(ordinates);
    }
    return points;
}

Result<std::vector<Point>> read_list(const Input& input, const Limits& limits, Point) {
    return read_points(input, limits);
}
Result<std::vector<Point3>> read_list(const Input& input, const Limits& limits, Point3) {
    return read_points3(input, limits);
}

template <class P>
Result<std::vector<P>> read_json(std::string_view text, const Limits& limits) {
    const auto document = JsonDocument::parse_features(text);
    if (!document) return tl::unexpected(document.error());
    const JsonValue root = document->root();
    const auto member = root.is_object() ? root.find("points") : std::nullopt;
    auto points = member ? read_list({"/points", "/points", *member}, limits, P())
                         : read_list({"the file", "", root}, limits, P());
    if (!points) points.error().field.clear();
    return points;
}

bool is_ply(std::string_view file) {
    return file.starts_with("ply\n") || file.starts_with("ply\r");
}

/// Reads the vertices of a PLY.
template <class P>
Result<std::vector<P>> read_ply(std::string_view file, const Limits& limits) {
    const auto header = read_ply_header(file);
    if (!header) return wrong(header.error().message);
    if (header->count("vertex") > limits.max_sites) return too_many(limits);
    const auto vertices = read_ply_points(file);
    if (!vertices) return wrong(vertices.error().message);
    std::vector<P> points(vertices->size());
    for (std::size_t i = 0; i < points.size(); ++i) {
        for (std::size_t axis = 0; axis < kAxes<P>; ++axis) {
            along(points[i], axis) = along((*vertices)[i], axis);
            if (!std::isfinite(along(points[i], axis)))
                return wrong("vertex " + std::to_string(i) + " of the PLY has no finite " + "xyz"[axis]);
        }
    }
    return points;
}

template <class P>
Result<std::vector<P>> read_file(std::string_view file, const Limits& limits) {
    file = without_byte_order_mark(file);
    if (is_npy(file)) return read_array<P>(file, limits);
    if (is_ply(file)) return read_ply<P>(file, limits);
    const auto start = trim(file, kBlanks);
    if (start.starts_with('{') || start.starts_with('[')) return read_json<P>(file, limits);
    const std::string_view kind = recognise_image(file) ? "a picture" : kind_of_file(file);
    if (kind == "CSV" || kind == "text" || kind.empty()) return read_csv<P>(file, limits);
    return wrong("the file " + std::string(kind == "empty" ? "is " : "seems to be ") + std::string(kind) +
                 "; points are read from CSV, JSON, NPY and PLY");
}

}  // namespace

Result<std::vector<Point>> read_point_file(std::string_view file, const Limits& limits) {
    return read_file<Point>(file, limits);
}

Result<std::vector<Point3>> read_point_file3(std::string_view file, const Limits& limits) {
    return read_file<Point3>(file, limits);
}

bool is_point_file3(std::string_view file) {
    file = without_byte_order_mark(file);
    if (is_ply(file)) return true;
    const auto start = trim(file, kBlanks);
    if (is_npy(file) || start.starts_with('{') || start.starts_with('[')) return false;
    CsvReader reader(file);
    return reader.next() && std::ranges::find(reader.fields(), "z") != reader.fields().end();
}

}  // namespace ccdt::api
