// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "api/json/feature_texts.h"
#include "api/json/json_document.h"
#include "api/run/options.h"
#include "core/base/result.h"
#include "core/geometry/point3.h"

namespace ccdt::api {

/// Kinds of files with a record for each point.
enum class PointFileKind : std::uint8_t {
    Csv,           ///< with a line that names the columns; separated by commas, semicolons or tabs
    Npy,           ///< array of numbers with a row for each point
    Ply,           ///< element `vertex`
    GeoJson,       ///< FeatureCollection of Points
    JsonLines,     ///< sequence of Features, or a single one
    JsonSequence,  ///< Features that each begin after a record separator (RFC 8142)
    Json,          ///< list of positions, or a geometry of GeoJSON
};

/// Columns that are read of the records of a file.
struct PointColumns {
    /// Names of the columns with the coordinates x, y and z. An empty name stands for x, y or z or, in CSV, common
    /// names of longitudes and latitudes. In NPY, columns are named by their number, from 0. GeoJSON has no such names.
    std::array<std::string, 3> axes = {};
    /// Names of columns or properties with numbers.
    std::vector<std::string> names = {};
    /// Name of a column or property with labels, which may be any text, number or boolean; empty: none.
    std::string label = {};
    /// Number of coordinates; 0: three if the file has a third one and no longitudes.
    std::size_t dimensions = 0;
    /// Whether each record stands for one point: then a feature of GeoJSON must have a single point, columns of CSV may
    /// be longitudes and latitudes, and records without coordinates are left out. Otherwise, only the points matter.
    bool by_record = false;
};

/// Labels of points. What is missing has the label "".
struct Labels {
    std::vector<std::string> names;     ///< in the order of their first appearance
    std::vector<std::uint32_t> number;  ///< [points] index of each point's name; empty without labels

    void add(std::string_view name);

private:
    std::map<std::string, std::uint32_t, std::less<>> numbers_;
};

/// Points that a file holds, and their records.
struct PointTable {
    PointFileKind kind = PointFileKind::Csv;
    std::size_t dimensions = 2;
    bool is_lonlat = false;           ///< whether the columns have names of longitudes and latitudes
    std::vector<Point3> positions;    ///< finite; z is 0 if there are two dimensions
    std::vector<std::uint32_t> rows;  ///< [positions] index of the record; empty if no record was left out
    /// [names][positions]; NaN for what is missing or not a number. Booleans are 0 and 1.
    std::vector<std::vector<double>> columns;
    Labels labels;
    std::vector<TextRange> records;  ///< of all rows; empty for NPY, and for lists and geometries in JSON
    TextRange body;                  ///< what lies between the head and the tail of the file, around all records
    std::size_t left_out = 0;        ///< number of records without coordinates

    /// Returns the index of a position's record in the file.
    std::uint32_t row_of(std::size_t position) const {
        return rows.empty() ? static_cast<std::uint32_t>(position) : rows[position];
    }
    /// Returns the record of a position for error messages, such as "line 7".
    std::string place_of(std::size_t position, std::string_view file) const;
};

/// Returns the label that a value of JSON stands for: a text, a number or a boolean; "" for null.
std::string label_of(JsonValue value);

/// Reads the points of a file. A byte order mark of UTF-8 is ignored. A CSV must have the same number of fields in
/// every line. Time: linear in the size of the file.
/// Errors: Malformed, with the line, row, vertex or JSON Pointer in the message; for an unknown column, Error::field is
/// its name; LimitExceeded for more than limits.max_sites records.
Result<PointTable> read_point_table(std::string_view file, const PointColumns& columns, const Limits& limits);

}  // namespace ccdt::api
