#include "api/output/point_table.h"

#include <array>
#include <bit>
#include <cstddef>

#include "api/output/numbers.h"

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

std::size_t count(std::span<const InkPoints> inks) {
    std::size_t points = 0;
    for (const InkPoints& ink : inks) points += ink.points.size();
    return points;
}

/// The beginning of an array's file, with room for the rest.
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

}  // namespace

std::string write_csv(std::span<const Point> points, const std::stop_token& stop) {
    std::string out;
    out.reserve((points.size() + 1) * kUsualLine);
    out += "x,y\r\n";
    append_lines(out, points, "\r\n", stop);
    return out;
}

std::string write_ink_csv(std::span<const InkPoints> inks, const std::stop_token& stop) {
    std::string out;
    out.reserve((count(inks) + 1) * (kUsualLine + kUsualName));
    out += "x,y,ink\r\n";
    for (const InkPoints& ink : inks) append_lines(out, ink.points, ',' + std::string(ink.name) + "\r\n", stop);
    return out;
}

std::string write_npy(std::span<const Point> points) {
    std::string out = npy_header(points.size(), 2);
    out.append(reinterpret_cast<const char*>(points.data()), points.size_bytes());
    return out;
}

std::string write_ink_npy(std::span<const InkPoints> inks) {
    std::string out = npy_header(count(inks), 3);
    double number = 0;
    for (const InkPoints& ink : inks) {
        for (const Point& point : ink.points) {
            const std::array<double, 3> row = {point.x, point.y, number};
            out.append(reinterpret_cast<const char*>(row.data()), sizeof(row));
        }
        ++number;
    }
    return out;
}

}  // namespace ccdt::api
