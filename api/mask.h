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

/// Kind of mask of thresholds: a tile of greys, of which each is as often as any other, and those below any grey are
/// spread evenly.
struct MaskFormat {
    FileFormat file;
    int bits;  ///< of a grey
};

/// Masks that /sample makes, by the option `format`.
std::span<const MaskFormat* const> mask_formats();

/// Pixels of a mask's side.
inline constexpr int kLeastMaskSide = 8;
inline constexpr int kMostMaskSide = 1'024;

/// Checks that a request for a mask has a torus of so many pixels.
/// Errors: Malformed, with a JSON Pointer.
Result<void> check_mask(const SampleRequest& request);

/// Answers a request for a mask. Errors: Stopped; Internal if memory runs out. Same request, same bytes.
Result<Answer> run_mask(const SampleRequest& request, const Control& control, Timings& timings);

Estimate cost_of_mask(const SampleRequest& request);

}  // namespace ccdt::api
