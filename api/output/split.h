// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <stop_token>

#include "api/output/formats.h"

namespace ccdt::api {

/// Writes a drawing of shapes. The options may split it into an archive of several files, which all have the same page:
/// one for each ink, such as `cyan.svg`, or several for each ink, such as `cyan-1.svg`, each of which a plotter draws
/// in a given time. Strokes are not cut, except for the line of the style Path. A stroke that takes longer has a file
/// of its own.
/// @param points, palette, page, path_stop, stop  as for write_svg()
/// Errors: LimitExceeded if there are too many files; Error::field is the name of an option.
Result<void> write_drawing(const PointFormat& format, const PointSet& points, const Palette& palette, const Page& page,
                           const DrawingOptions& drawing, Body& body, const std::stop_token& path_stop,
                           const std::stop_token& stop);

}  // namespace ccdt::api
