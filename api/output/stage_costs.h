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

/// Converts an estimate to a cost. Adds the memory that every request takes.
Cost total_cost(const Estimate& estimate);

/// Bytes per pixel of a decoded grey picture: luminance, alpha, coverage and a vertically flipped copy, 4 bytes each.
inline constexpr double kGreyPlanes = 16;

/// Estimates the cost of decoding an image.
/// @param planes  memory of all planes that are made from the image, in bytes per pixel
Estimate decoding_cost(const ImageFile& file, double planes = kGreyPlanes);

/// Estimates the cost of computing the integrals of a density grid.
Estimate density_cost(double cells);

/// Estimates the cost of finding the zones of a density. The time is the time for noise, which takes longest.
Estimate zones_cost(double cells);

/// Estimates the cost of drawing dots as pixels.
/// @param radius  radius of the dots in pixels, may exceed the picture; none: follows from the wanted coverage
Estimate raster_cost(double sites, double pixels, std::optional<double> radius, bool antialias);

/// Estimates the cost of writing the circles or spirals that fill dots, and of the files of a split drawing.
/// @param radius  radius of the dots, in millimetres
Estimate turns_cost(const PointFormat& format, const DrawingOptions& drawing, double sites, double radius);

/// Estimates the cost of writing a drawing. If dots are shapes, a raster determines their radius, and is freed before
/// the shapes are written. If the drawing consists of pixels, the raster is kept until they are written.
/// @param raster  result of raster_cost()
Estimate drawing_cost(const PointFormat& format, const Estimate& raster, double sites, double pixels);

/// Returns an upper estimate of the size of an answer with points, in bytes.
/// @param pixels  number of pixels of a drawing, for each ink
/// @param turns   result of turns_cost()
/// @param mesh    whether the answer contains the triangulation
double largest_answer(const PointFormat& format, double sites, double pixels, const Estimate& turns, bool mesh);

/// Returns the number of bytes of an image file that a request holds in memory in addition to its body; 0 if the file
/// is a part of the body.
std::size_t bytes_of(const ImageFile& file);

}  // namespace ccdt::api
