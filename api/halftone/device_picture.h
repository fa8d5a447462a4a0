// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "api/decode/decode.h"
#include "api/halftone/halftone_input.h"
#include "api/image/device_writers.h"
#include "api/input/device.h"
#include "api/input/file_formats.h"
#include "api/input/picture_options.h"
#include "api/output/body.h"
#include "api/run/deadline.h"
#include "api/run/options.h"
#include "core/base/result.h"
#include "core/ccdt/plane/ccdt.h"
#include "core/picture/levels.h"

namespace ccdt::api {

/// Format of pictures for devices.
struct DeviceFormat {
    FileFormat file;
    Result<std::string> (*write)(const DevicePixels& pixels, const PixelOptions& options, const std::stop_token& stop);
};

/// Request to /halftone with the option `device`: a picture that has exactly the pixels and the colours of a device.
struct DeviceRequest {
    ImageFile image;
    std::string image_field;  ///< Error::field of errors about the image; empty unless the body is JSON
    Device device;
    /// Size of the answer, in pixels. If only one side is given, the other follows from the aspect ratio of the
    /// picture. If no side is given, the answer has the size of the picture. The size of the picture is that after the
    /// turn by `quarters`.
    std::optional<int> width;
    std::optional<int> height;
    /// Contain: the answer shows the whole picture, and the background fills the rest of the answer's pixels. Cover
    /// requires width and height.
    Fit fit = Fit::Contain;
    Focus gravity;     ///< point of the turned picture that Cover shows as near to the middle as possible
    int quarters = 0;  ///< number of quarter turns clockwise, done before the picture is scaled
    Colour background = kWhite;
    AlphaMixing alpha = AlphaMixing::Display;  ///< how partly transparent pixels show the background
    Levels levels;
    double spot = 0;  ///< diameter of printed spots in pixels; 0: pixels are squares
    PixelOptions pixels;
    const DeviceFormat* format = nullptr;  ///< never null in a parsed request
    OnStop on_deadline = OnStop::Error;    ///< a partial answer shows the picture less accurately
};

/// Returns the formats, in the server's order of preference.
std::span<const DeviceFormat* const> device_formats();

/// Returns the names of the options. Each option may be given as text.
std::vector<std::string_view> device_options();

/// Reads the options of a request that has the option `device`.
/// Errors: as for parse_halftone(). Malformed for options that apply only to dots.
Result<DeviceRequest> parse_device(const HalftoneInput& input, std::string_view accept, const Limits& limits);

/// Decodes the picture, scales it, and shows it in the colours of the device.
///
/// A pixel of the scaled picture whose colour is in Device::sent keeps this colour, so that text stays sharp.
/// Errors: those of `decode`; LimitExceeded if the answer would have more than limits.max_pixels; Stopped, unless the
/// request accepts a partial result and the stop comes after decoding and scaling. The same request gives the same
/// bytes.
Result<Answer> run_device(const DeviceRequest& request, const Limits& limits, const Decode& decode,
                          const Control& control, Timings& timings);

/// Estimates the cost of run_device().
Cost cost_of(const DeviceRequest& request, const Limits& limits);

/// Returns the size of a parsed request in bytes, without the body from which it was read.
std::size_t size_of(const DeviceRequest& request);

}  // namespace ccdt::api
