#include "api/output/point_table.h"

#include <array>
#include <bit>
#include <cstddef>
#include <string_view>

#include "api/text/numbers.h"

namespace ccdt::api {
namespace {

constexpr std::size_t kStopStride = 4'096;  ///< points between two looks at the stop token
constexpr std::size_t kUsualLine = 40;      ///< two numbers of 18 characters, a comma, the end of the line
constexpr std::size_t kUsualName = 8;       ///< of an ink, with its comma
constexpr std::size_t kNpyAlignment = 64;   ///< of where the numbers begin

/// @param end  of each line
void append_lines(std::string& out, std::span<const Point> points, std::string_view end, const std::stop_token& stop) {
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (i % kStopStride == 0 && stop.stop_requested()) break;
        append_shortest(out, points[i].x);
        out += ',';
        append_shortest(out, points[i].y);
        out += end;
    }
}

/// Writes the beginning of an array's file, with room for the rest.
std::string npy_header(std::size_t rows, std::size_t columns) {
    static_assert(std::endian::native == std::endian::little && sizeof(Point) == 2 * sizeof(double));
    constexpr std::string_view kMagic("\x93NUMPY\x01\x00", 8);
    std::string header = "{'descr': '<f8', 'fortran_order': False, 'shape': (" + std::to_string(rows) + ", " +
                         std::to_string(columns) + "), }";
    const std::size_t length = kMagic.size() + 2 + header.size() + 1;
    header.append((kNpyAlignment - length % kNpyAlignment) % kNpyAlignment, ' ') += '\n';

    std::string out;
    out.reserve(length + kNpyAlignment + rows * columns * sizeof(double));
    out += kMagic;
    out += static_cast<char>(header.size() & 255);
    out += static_cast<char>(header.size() >> 8);
    out += header;
    return out;
}

/// Quotes a field that has what parts fields (RFC 4180).
std::string quoted(std::string_view text) {
    if (text.find_first_of(",\"\r\n") == std::string_view::npos) return std::string(text);
    std::string out = "\"";
    for (const char c : text) out.append(c == '"' ? 2 : 1, c);
    return out + '"';
}

}  // namespace

std::string write_csv(std::span<const InkDots> inks, const std::stop_token& stop) {
    const bool named = are_named(inks);
    std::string out;
    out.reserve((count_points(inks) + 1) * (kUsualLine + (named ? kUsualName : 0)));
    out += named ? "x,y,ink\r\n" : "x,y\r\n";
    for (const auto& [ink, dots, radius] : inks)
        append_lines(out, dots.points, named ? ',' + ink.name + "\r\n" : "\r\n", stop);
    return out;
}

std::string write_npy(std::span<const InkDots> inks) {
    const std::size_t columns = are_named(inks) ? 3 : 2;
    std::string out = npy_header(count_points(inks), columns);
    double number = 0;
    for (const InkDots& each : inks) {
        for (const Point& point : each.dots.points) {
            const std::array<double, 3> row = {point.x, point.y, number};
            out.append(reinterpret_cast<const char*>(row.data()), columns * sizeof(double));
        }
        ++number;
    }
    return out;
}

std::string write_map_csv(const MapOfDots& map, const std::stop_token& stop) {
    const bool named = map.are_named();
    std::string out;
    out.reserve((map.size() + 1) * (kUsualLine + kUsualName));
    out += named ? "x,y,feature,class\r\n" : "x,y,feature\r\n";
    for (const MapDots& each : map.classes) {
        const std::string end = named ? ',' + quoted(each.ink.name) + "\r\n" : "\r\n";
        for_features(each.dots, [&](std::uint32_t feature, std::size_t first, std::size_t count) {
            append_lines(out, std::span(each.dots.dots.points).subspan(first, count),
                         ',' + std::to_string(feature) + end, stop);
        });
    }
    return out;
}

std::string write_map_npy(const MapOfDots& map) {
    const std::size_t columns = map.are_named() ? 4 : 3;
    std::string out = npy_header(map.size(), columns);
    double number = 0;
    for (const MapDots& each : map.classes) {
        for (std::size_t i = 0; i < each.dots.feature_of.size(); ++i) {
            const Point point = each.dots.dots.points[i];
            const std::array<double, 4> row = {point.x, point.y, static_cast<double>(each.dots.feature_of[i]), number};
            out.append(reinterpret_cast<const char*>(row.data()), columns * sizeof(double));
        }
        ++number;
    }
    return out;
}

}  // namespace ccdt::api
