// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <pybind11/numpy.h>

#include "api/decode/decode.h"
#include "api/image/image_header.h"
#include "core/base/result.h"

namespace ccdt::python {

/// Describes an array of pixels as a file whose header is known. The bytes of the file are the samples. Only estimates
/// of memory use them.
/// @param pixels  [height, width, channels], contiguous
/// Errors: LimitExceeded for more than max_pixels pixels.
Result<api::ImageFile> file_of(const pybind11::array& pixels, std::size_t max_pixels);

/// Returns decoders that read the array, whatever bytes they receive. The light is that of a PNG file with the same
/// samples. The decoders do not touch Python objects, so they may run without the interpreter's lock.
/// @param pixels  [height, width, channels] of uint8, uint16 or float32, contiguous; must outlive the decoders. One
///                channel is grey, three are red, green and blue. A second or a fourth channel is alpha.
/// @param linear  whether the samples are linear light; otherwise they are sRGB values
api::Decode decode_array(const pybind11::array& pixels, bool linear);

}  // namespace ccdt::python
