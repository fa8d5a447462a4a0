// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "api/output/body.h"
#include "api/output/formats.h"
#include "api/output/json_writer.h"
#include "api/output/page.h"
#include "api/run/options.h"
#include "api/sample/plane/map_drawing.h"
#include "api/sample/plane/sample_request.h"
#include "core/base/result.h"
#include "core/ccdt/maps/dot_map.h"
#include "core/ccdt/plane/ccdt.h"

namespace ccdt::api {

/// Lengths in pixels that determine the size of a drawing if the request gives no width. The pitch of the points, which
/// is SampleDrawing::pitch, is kPixelPitch pixels, but the longer side of the drawing has at least kMinDrawingSide and
/// at most kMaxDrawingSide pixels. The format and limits.max_pixels can make the drawing smaller.
inline constexpr double kPixelPitch = 8;
inline constexpr double kMinDrawingSide = 512;
inline constexpr double kMaxDrawingSide = 16'384;

/// Plans the page of a drawing. If the request gives no width, the page has at most limits.max_pixels. Errors:
/// LimitExceeded for a requested width that makes more pixels, and for a side that is longer than the format allows;
/// those of place_on_paper() and VectorWriter::check().
Result<Page> plan_page(const SampleRequest& request, const PointFormat& format, const SampleDrawing& drawn,
                       const Limits& limits);

/// Writes the points of a sample in a format, which need not be that of the request.
///
/// @param drawn  result of plan_drawing()
/// @param dots   in the plane of the drawing if the format draws; for a dot map, [classes]; otherwise one element with
/// all points. If the request has features, the
///               points are grouped by feature.
/// Errors: those of the format's writer; Stopped.
Result<void> write_sample(const SampleRequest& request, const PointFormat& format, const SampleDrawing& drawn,
                          const Page& page, std::span<const ClassDots> dots, const Report& report,
                          const Control& control, Body& body);

}  // namespace ccdt::api
