#include "api/output/point_table.h"

#include <bit>
#include <cstddef>
#include <string_view>

#include "api/output/numbers.h"

namespace ccdt::api {
namespace {

constexpr std::size_t kStopStride = 4'096;  ///< points between two looks at the stop token
constexpr std::size_t kUsualLine = 40;      ///< two numbers of 18 characters, a comma, the end of the line
constexpr std::size_t kNpyAlignment = 64;   ///< of where the numbers begin

}  // namespace

std::string write_csv(std::span<const Point> points, const std::stop_token& stop) {
    std::string out;
    out.reserve((points.size() + 1) * kUsualLine);
    out += "x,y\r\n";
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (i % kStopStride == 0 && stop.stop_requested()) break;
        append_shortest(out, points[i].x);
        out += ',';
        append_shortest(out, points[i].y);
        out += "\r\n";
    }
    return out;
}

std::string write_npy(std::span<const Point> points) {
    static_assert(std::endian::native == std::endian::little && sizeof(Point) == 2 * sizeof(double));
    constexpr std::string_view kMagic("\x93NUMPY\x01\x00", 8);
    std::string header =
        "{'descr': '<f8', 'fortran_order': False, 'shape': (" + std::to_string(points.size()) + ", 2), }";
    const std::size_t length = kMagic.size() + 2 + header.size() + 1;
    header.append((kNpyAlignment - length % kNpyAlignment) % kNpyAlignment, ' ') += '\n';

    std::string out;
    out.reserve(length + kNpyAlignment + points.size_bytes());
    out += kMagic;
    out += static_cast<char>(header.size() & 255);
    out += static_cast<char>(header.size() >> 8);
    out += header;
    out.append(reinterpret_cast<const char*>(points.data()), points.size_bytes());
    return out;
}

}  // namespace ccdt::api
