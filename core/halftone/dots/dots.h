// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/base/executor.h"
#include "core/geometry/point.h"

namespace ccdt {

/// A canvas that dots are drawn on.
struct Canvas {
    int width = 0;     ///< pixels
    int height = 0;    ///< pixels
    double scale = 1;  ///< canvas pixels per unit of the dots' coordinates
};

/// The coverage of each pixel by dots, from 0 to 255 (fully covered). Binary rasters contain 0 and 255 only.
struct Raster {
    int width = 0;
    int height = 0;
    double radius = 0;                   ///< radius of the dots in pixels
    std::vector<std::uint8_t> coverage;  ///< [width * height], row by row from the top
};

struct DotOptions {
    std::optional<double> radius;  ///< pixels, >= 0, finite; none: chosen such that the mean is `mean_coverage`
    double mean_coverage = 0;      ///< mean of the raster, in [0, 1]; used only without `radius`
    bool antialias = false;        ///< whether rims are antialiased; if not, a pixel is covered if its centre is
    /// Number of samples along each side of a pixel. A pixel is the mean of its samples, so the total coverage is that
    /// of exact discs. Requires `radius`. Without samples (0), only the nearest dot determines the coverage of a pixel.
    int samples = 0;
};

/// Limit on the samples of a whole canvas: samples_for() chooses more than one sample per pixel only if the canvas then
/// has at most this many samples.
inline constexpr double kMaxSamples = 16e6;

/// Returns a number of samples along each side of a pixel that gives dots the coverage of exact discs. Chooses at least
/// three samples per radius, or fewer if the whole canvas would need more than kMaxSamples. Binary dots with a radius
/// of 1.5 pixels or more need only one sample.
/// @param radius     radius of the dots in pixels
/// @param antialias  whether dots are antialiased, not binary
int samples_for(double radius, const Canvas& canvas, bool antialias);

/// Draws discs of equal size. Without dots, the raster is blank. Where discs overlap, the area counts once.
///
/// If the radius is chosen for `mean_coverage`, the mean of an antialiased raster is exact to one part in 10,000. The
/// mean of a binary raster is exact to one pixel, except if several pixels are at exactly the chosen radius from the
/// nearest dot. If a binary raster has several samples per pixel, diffuse() rounds the means to 0 or 255.
///
/// @param dots    finite; may lie outside the canvas
/// @param canvas  at least 1 x 1; its scale positive
/// @param stop    polled at each dot; after a stop the result must not be used
/// Deterministic for any number of threads. O(pixels + dots + total area of the dots).
Raster draw_dots(std::span<const Point> dots, const Canvas& canvas, const DotOptions& options,
                 const std::stop_token& stop = {}, Executor& executor = inline_executor());

}  // namespace ccdt
