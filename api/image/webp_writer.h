// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <stop_token>
#include <string>

#include "api/image/overlay.h"
#include "core/base/result.h"

namespace ccdt::api {

inline constexpr int kMaxWebPSide = 16'383;  ///< pixels

/// Encodes a picture as a lossless WebP file. WebP cannot store a physical size, so the width in millimetres is
/// ignored.
///
/// @param image  each side at most kMaxWebPSide
/// The same input gives the same bytes. Errors: Stopped; Internal if memory runs out.
Result<std::string> write_webp(const DotImage& image, std::optional<double> width_mm = {},
                               const std::stop_token& stop = {});

}  // namespace ccdt::api
