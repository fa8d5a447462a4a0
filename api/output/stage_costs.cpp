// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/output/stage_costs.h"

#include <algorithm>
#include <vector>

#include "api/output/plot.h"

namespace ccdt::api {

Cost total_cost(const Estimate& estimate) {
    constexpr double kFixedBytes = 6 << 20;
    return {static_cast<std::size_t>(estimate.bytes + kFixedBytes), estimate.seconds};
}

Estimate decoding_cost(const ImageFile& file, double planes) {
    constexpr double kTime = 0.03 * kMicrosecond;
    const auto pixels = static_cast<double>(file.header.pixels());
    const double decoder = static_cast<double>(file.header.decoder_bytes) + static_cast<double>(file.bytes.size());
    return {pixels * planes + decoder, pixels * kTime};
}

Estimate density_cost(double cells) {
    return {cells * 20, cells * 0.03 * kMicrosecond};
}

Estimate zones_cost(double cells) {
    return {cells * 9, cells * 0.3 * kMicrosecond};
}

Estimate raster_cost(double sites, double pixels, std::optional<double> radius, bool antialias) {
    const double covered = sites * std::min(pixels, radius ? 4 * *radius * *radius : 0);
    return {sites * 166 + pixels * 6, (pixels * (antialias ? 0.04 : 0.005) + covered * 0.001) * kMicrosecond};
}

Estimate turns_cost(const PointFormat& format, const DrawingOptions& drawing, double sites, double radius) {
    const VectorWriter* const shapes = format.vector();
    if (shapes == nullptr) return {};
    const std::vector<Point> stroke =
        dot_stroke(drawing.style, std::min(kMaxTurns * drawing.pen_mm, radius), drawing.pen_mm);
    constexpr double kCopies = 160;  // bytes of a dot in the files and in the archive
    const Estimate turns = shapes->per_turn_point * (static_cast<double>(stroke.size() - 1) * sites);
    return drawing.is_split ? turns * 3 + Estimate{kCopies * sites, 0} : turns;
}

Estimate drawing_cost(const PointFormat& format, const Estimate& raster, double sites, double pixels) {
    const Estimate writing = format.per_site * sites + format.per_pixel * pixels;
    return format.raster() == nullptr ? then(raster, writing) : raster + writing;
}

double largest_answer(const PointFormat& format, double sites, double pixels, const Estimate& turns, bool mesh) {
    // Measured bytes per site: 46 for numbers with an exponent, which is 34 more than `least` for a Feature; 62 for a
    // circle in PDF; 73 for triangles. The pixels of an ink have one byte before they are compressed.
    constexpr double kHead = 16'384, kNumbers = 60, kShape = 80, kTriangles = 100;
    if (format.raster() != nullptr) return kHead + pixels;
    if (format.vector() != nullptr) return kHead + kShape * sites + turns.bytes;
    const double numbers = format.file.name == kNpy.name ? 0 : kNumbers + (mesh ? kTriangles : 0);
    return kHead + (static_cast<double>(format.least) + numbers) * sites;
}

std::size_t bytes_of(const ImageFile& file) {
    return file.decoded ? file.decoded->size() : 0;
}

}  // namespace ccdt::api
