// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "api/input/domain_reader.h"
#include "api/input/file_formats.h"
#include "api/run/estimate.h"
#include "api/run/options.h"
#include "core/base/result.h"
#include "core/ccdt/plane/ccdt.h"

namespace ccdt::api {

/// Format of a threshold mask: a tile of grey values in which all values are equally frequent. For any threshold, the
/// pixels below it are spread evenly. A mask may have frames. In a PNG file, they are stacked from top to bottom; in a
/// NumPy file, they are the first axis.
struct MaskFormat {
    FileFormat file;
    int bits;               ///< bits of each grey value
    bool is_array = false;  ///< whether the file is a NumPy file
};

/// Returns the formats of masks that /sample offers as values of the option `format`.
std::span<const MaskFormat* const> mask_formats();

/// Limits on the side of a mask, in pixels.
inline constexpr int kMinMaskSide = 8;
inline constexpr int kMaxMaskSide = 1'024;
inline constexpr int kMaxMaskDepth = 256;          ///< in frames
inline constexpr double kMaxMaskPixels = 1 << 22;  ///< of all frames together

/// Request to /sample for a threshold mask.
struct ThresholdMask {
    const MaskFormat* format;
    Rectangle torus = {};              ///< its sides are the width and the height of the mask in pixels
    std::optional<double> depth = {};  ///< number of frames; none: a single picture
    std::uint64_t seed = 0;
};

/// Checks that the domain of a mask is a torus whose sides are integers within the limits.
/// @param domain        domain of the request; null if it is a polygon
/// @param depth         number of frames, if the domain has a depth
/// @param format_field  field of the option `format`, for errors
/// Errors: Malformed.
Result<void> check_mask(const Rectangle* domain, std::optional<double> depth, const std::string& format_field);

/// Computes a mask and encodes it. Errors: Stopped; Internal if memory runs out. The same request gives the same
/// bytes.
Result<Answer> run_mask(const ThresholdMask& mask, const Control& control, Timings& timings);

/// Estimates the cost of run_mask().
Estimate cost_of_mask(const ThresholdMask& mask);

}  // namespace ccdt::api
