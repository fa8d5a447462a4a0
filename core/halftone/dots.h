// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/geometry/point.h"
#include "core/parallel/executor.h"

namespace ccdt {

/// Canvas that dots are drawn on.
struct Canvas {
    int width = 0;     ///< pixels
    int height = 0;    ///< pixels
    double scale = 1;  ///< canvas pixels per unit of the dots' coordinates
};

/// Share of each pixel that dots cover, row by row, 255 being all of it. Binary rasters hold 0 and 255 only.
struct Raster {
    int width = 0;
    int height = 0;
    double radius = 0;                   ///< of the dots, in pixels
    std::vector<std::uint8_t> coverage;  ///< [width * height]
};

struct DotOptions {
    std::optional<double> radius;  ///< pixels, >= 0, finite; none: such that the mean coverage is `mean_coverage`
    double mean_coverage = 0;      ///< in [0, 1]
    bool antialias = false;        ///< false: a pixel is covered if its centre is
    /// A side, of whose mean each pixel is made, such that dots cover what discs do: with a radius only. None:
    /// antialiased pixels tell of their nearest dot alone.
    int samples = 0;
};

inline constexpr double kMostSamples = 16e6;

/// Samples a side with which dots of a radius, in pixels, cover what discs do: as many as bring the radius to three
/// samples, as long as the whole canvas has kMostSamples at most; one for binary dots of 1.5 pixels or more.
int samples_for(double radius, const Canvas& canvas, bool antialias);

/// Draws equal discs; without dots the raster stays empty. Overlaps count once, also in the choice of the radius: the
/// mean of the raster is `mean_coverage` to the pixel (binary; pixels exactly as far from their dots as the last one
/// needed are covered with it) or to one part in 10,000 (antialiased).
///
/// Binary rasters of several samples are diffuse()d.
///
/// @param dots    finite; may lie beyond the canvas
/// @param canvas  at least 1 x 1, its scale positive
/// @param stop    asked at each dot; a stop ends it early, with nothing of use
/// Same input, same bytes, whatever the executor. O(pixels + dots), and the area of all dots.
Raster draw_dots(std::span<const Point> dots, const Canvas& canvas, const DotOptions& options,
                 const std::stop_token& stop = {}, Executor& executor = inline_executor());

/// Draws discs each with a radius of its own, overlaps counted once.
///
/// @param dots       finite; may lie beyond the canvas
/// @param radii      [dots] in units of the dots' coordinates, >= 0
/// @param antialias  false: a pixel is covered if its centre is
/// @param samples    a side, of whose mean each pixel is made; if more than 1 the raster is antialiased in any case
/// @param stop       asked at each dot; a stop ends it early, with nothing of use
/// Same input, same bytes, on any executor. O(pixels + dots), and the area of all dots.
Raster draw_dots(std::span<const Point> dots, std::span<const float> radii, const Canvas& canvas, bool antialias,
                 int samples, const std::stop_token& stop = {}, Executor& executor = inline_executor());

}  // namespace ccdt
