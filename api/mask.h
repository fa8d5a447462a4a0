// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "api/image/image_codec.h"
#include "api/input/file_formats.h"
#include "api/run/estimate.h"
#include "api/run/options.h"
#include "core/ccdt/ccdt.h"
#include "core/result.h"

namespace ccdt::api {

struct SampleRequest;

/// Format of a threshold mask: a tile of grey values in which all values are equally frequent. For any threshold, the
/// pixels below it are spread evenly.
struct MaskFormat {
    FileFormat file;
    int bits;  ///< bits of each grey value
};

/// Returns the formats of masks that /sample offers as values of the option `format`.
std::span<const MaskFormat* const> mask_formats();

/// Limits on the side of a mask, in pixels.
inline constexpr int kMinMaskSide = 8;
inline constexpr int kMaxMaskSide = 1'024;

/// Checks that the domain of a request for a mask is a torus whose sides are integers within these limits.
/// Errors: Malformed, with a JSON Pointer.
Result<void> check_mask(const SampleRequest& request);

/// Answers a request for a mask. Errors: Stopped; Internal if memory runs out. Same request, same bytes.
Result<Answer> run_mask(const SampleRequest& request, const Control& control, Timings& timings);

Estimate cost_of_mask(const SampleRequest& request);

}  // namespace ccdt::api
