// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <stop_token>
#include <vector>

#include "core/base/executor.h"
#include "core/geometry/point.h"
#include "core/halftone/dots/dots.h"
#include "core/halftone/field/field_plan.h"
#include "core/halftone/field/spot_field.h"
#include "core/picture/reduction.h"

namespace ccdt {

/// Number of pixels, along each axis, that suffice to draw the spacing of dots precisely.
inline constexpr double kPixelsOfPitch = 12;

/// A picture drawn by the spot function of its sites: ink lies where the spot function exceeds a threshold that follows
/// the light of the picture.
///
/// The threshold is corrected in some rounds, until means of ink over a little more than half the local spacing equal
/// those of the picture.
class FieldDrawing {
public:
    /// @param sites     in units of the plan's cells
    /// @param canvas    pixels of the raster for which the drawing is fitted; none: it is fitted for outlines
    /// @param stop      polled once per round; after a stop, the drawing is less accurate
    /// @param executor  must outlive this object
    /// Deterministic for any number of threads. O(sites log sites + pixels).
    FieldDrawing(const FieldPlan& plan, std::span<const Point> sites, const std::optional<CellGrid>& canvas,
                 const std::stop_token& stop = {}, Executor& executor = inline_executor());

    /// Draws the darker side of each channel. If the plan has sets of inks, each channel is a boundary between two
    /// sets, and its darker side contains the darker side of the previous boundary.
    ///
    /// @param antialias  if false, pixels are 0 or 255. If triangles have few pixels, round_dots() then rounds the
    ///                   coverage of the pixels, so that tones stay exact.
    /// @returns          [channels]
    std::vector<Raster> rasters(int width, int height, bool antialias) const;

    /// Returns the outlines of the darker side of each channel, where the picture is [0, 1] x [0, 1]. They enclose it
    /// by the even-odd rule.
    /// @param lighter  whether the lighter side is enclosed instead
    std::vector<std::vector<std::vector<Point>>> outlines(bool lighter = false) const;

private:
    /// Returns the change of the spot function within a pixel at its peaks.
    float least_slope(int width) const { return static_cast<float>(0.5 / (pitch_ * width)); }
    /// Calls draw(band, begin, end) for bands of rows of a canvas.
    template <class Draw>
    void for_bands(const CellGrid& canvas, const Draw& draw) const;
    /// Returns the share of ink in each cell of the fit, if a channel is drawn on a canvas.
    std::vector<float> drawn_ink(const std::vector<float>& start, const std::vector<float>& threshold,
                                 const CellGrid& canvas) const;
    void nest(std::vector<Raster>& rasters, std::size_t begin, std::size_t end) const;

    bool is_nested_;  ///< whether the darker side of a channel contains the darker side of the previous channel
    double pitch_;    ///< share of the width of the picture
    SpotTriangles triangles_;
    CellGrid cells_;                              ///< of the fit
    std::vector<float> spots_;                    ///< [cells] spot function
    std::vector<std::vector<float>> starts_;      ///< [channels][cells] thresholds before the fit
    std::vector<std::vector<float>> thresholds_;  ///< [channels][cells]
    Executor& executor_;
};

}  // namespace ccdt
