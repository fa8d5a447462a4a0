// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>

#include "api/image/image_header.h"
#include "api/input/drawing_options.h"
#include "api/output/formats.h"
#include "api/run/estimate.h"
#include "api/run/options.h"

namespace ccdt::api {

// Estimates of the stages that several endpoints share. The model is fitted to measured peaks of resident memory and to
// measured times of the whole program; tests/api/cost_test.cpp compares estimates with measurements.

/// Adds the memory that each request takes.
Cost total_cost(const Estimate& estimate);

/// Bytes per pixel of a decoded grey picture: luminance, alpha, coverage and a vertically flipped copy, 4 bytes each.
inline constexpr double kGreyPlanes = 16;

/// @param planes  bytes per pixel
Estimate decoding_cost(const ImageFile& file, double planes = kGreyPlanes);

/// Estimates the integrals of a density grid.
Estimate density_cost(double cells);

/// Estimates the drawing of dots as pixels.
/// @param radius  radius of the dots, in pixels; a dot may cover the whole drawing
Estimate raster_cost(double sites, double pixels, std::optional<double> radius, bool antialias);

/// Estimates the writing of the circles or spirals that fill dots.
/// @param radius  radius of the dots, in millimetres
Estimate turns_cost(const PointFormat& format, const DrawingOptions& drawing, double sites, double radius);

/// Estimates the writing of a drawing. The radius of shapes is determined with a raster, which is freed before the
/// shapes are written. A drawing in pixels keeps the raster while it is written.
Estimate drawing_cost(const PointFormat& format, const Estimate& raster, double sites, double pixels);

/// Returns the size of an image that a request holds in addition to its body.
std::size_t bytes_of(const ImageFile& file);

}  // namespace ccdt::api
