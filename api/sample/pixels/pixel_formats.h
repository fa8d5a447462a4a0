// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <stop_token>

#include "api/input/file_formats.h"
#include "api/output/body.h"
#include "core/base/result.h"

namespace ccdt::api {

/// A set of pixels, as an answer has it.
struct ChosenPixels {
    int width = 0;
    int height = 0;
    std::span<const std::uint8_t> chosen;  ///< [width * height] row by row, 1 for the pixels of the set
    std::size_t count = 0;                 ///< number of pixels of the set
    std::uint64_t seed = 0;
    bool partial = false;  ///< whether the run was stopped early
};

/// Format of sets of pixels. Same set, same bytes. Errors of `write`: Stopped; Internal if memory runs out.
struct PixelFormat {
    FileFormat file;
    double bytes_per_site;   ///< memory of a pixel of the set in the answer
    double bytes_per_pixel;  ///< memory of any pixel in the answer
    Result<void> (*write)(const ChosenPixels& set, Body& body, const std::stop_token& stop);
};

/// Returns the formats, in the server's order of preference: lists in JSON and CSV, and masks in PNG and NPY.
std::span<const PixelFormat* const> pixel_formats();

}  // namespace ccdt::api
