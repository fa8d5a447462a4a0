// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/analyze/point_file_reader.h"

#include <algorithm>
#include <utility>

#include "api/input/npy_reader.h"
#include "api/surface/ply.h"
#include "api/table/csv_reader.h"
#include "api/table/point_table.h"
#include "api/text/byte_order_mark.h"
#include "api/text/text.h"

namespace ccdt::api {

Result<std::vector<Point>> read_point_file(std::string_view file, const Limits& limits) {
    return read_point_table(file, {.dimensions = 2}, limits).map([](const PointTable& table) {
        std::vector<Point> points;
        points.reserve(table.positions.size());
        for (const Point3 p : table.positions) points.push_back({p.x, p.y});
        return points;
    });
}

Result<std::vector<Point3>> read_point_file3(std::string_view file, const Limits& limits) {
    return read_point_table(file, {.dimensions = 3}, limits).map([](PointTable table) {
        return std::move(table.positions);
    });
}

bool is_point_file3(std::string_view file) {
    file = without_byte_order_mark(file);
    if (is_ply(file)) return true;
    if (is_npy(file) || begins_like_json(file, " \t\r\n\x1E")) return false;
    CsvReader reader(file, CsvReader::find_separator(file));
    return reader.next() && std::ranges::find(reader.fields(), "z") != reader.fields().end();
}

}  // namespace ccdt::api
