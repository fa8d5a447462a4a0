// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/pixels/pixel_formats.h"

#include <array>
#include <string>
#include <string_view>
#include <utility>

#include "api/image/device_writers.h"
#include "api/output/npy_header.h"
#include "api/run/deadline.h"

namespace ccdt::api {
namespace {

std::size_t columns_of(const ChosenPixels& set) {
    return static_cast<std::size_t>(set.width);
}

/// Writes the coordinates of the pixels, row by row.
/// @param separator  between two pixels
Result<void> write_pixels(const ChosenPixels& set, std::string_view begin, std::string_view separator,
                          std::string_view end, Body& body, const std::stop_token& stop) {
    std::string& out = body.text();
    bool is_first = true;
    for (int y = 0; y < set.height; ++y) {
        if (!body.flush()) return {};  // the answer's end reports the error of the sink
        if (auto going = check_stop(stop); !going) return going;
        const std::string row = ',' + std::to_string(y) + std::string(end);
        for (std::size_t x = 0; x < columns_of(set); ++x) {
            if (set.chosen[static_cast<std::size_t>(y) * columns_of(set) + x] == 0) continue;
            if (!std::exchange(is_first, false)) out += separator;
            out.append(begin).append(std::to_string(x)).append(row);
        }
    }
    return {};
}

Result<void> write_json(const ChosenPixels& set, Body& body, const std::stop_token& stop) {
    body.text() += "{\"points\":[";
    auto written = write_pixels(set, "[", ",", "]", body, stop);
    body.text() += "],\"sites\":" + std::to_string(set.count) + ",\"seed\":" + std::to_string(set.seed) +
                   ",\"width\":" + std::to_string(set.width) + ",\"height\":" + std::to_string(set.height) +
                   (set.partial ? ",\"partial\":true}\n" : "}\n");
    return written;
}

Result<void> write_csv(const ChosenPixels& set, Body& body, const std::stop_token& stop) {
    body.text() += "x,y\r\n";
    return write_pixels(set, "", "", "\r\n", body, stop);
}

/// Writes a picture of 1 bit per pixel, in which the pixels of the set are white.
Result<void> write_png(const ChosenPixels& set, Body& body, const std::stop_token& stop) {
    constexpr std::array kColours = {kBlack, kWhite};
    const DevicePixels pixels{set.width, set.height, 1, true, kColours, set.chosen};
    return write_device_png(pixels, {}, stop).map([&](std::string&& file) { body.text() = std::move(file); });
}

/// Writes an array of booleans [height, width].
Result<void> write_npy(const ChosenPixels& set, Body& body, const std::stop_token& stop) {
    const std::string header = npy_header("|b1", static_cast<std::size_t>(set.height), columns_of(set));
    body.expect(header.size() + set.chosen.size());
    body.text() += header;
    for (std::span rest = set.chosen; !rest.empty(); rest = rest.subspan(columns_of(set))) {
        if (!body.flush()) return {};
        if (auto going = check_stop(stop); !going) return going;
        body.text().append(reinterpret_cast<const char*>(rest.data()), columns_of(set));
    }
    return {};
}

constexpr PixelFormat kJsonPixels{kJson, 28, 0, write_json};
constexpr PixelFormat kCsvPixels{kCsv, 28, 0, write_csv};
constexpr PixelFormat kPngPixels{kPng, 0, 0.5, write_png};
constexpr PixelFormat kNpyPixels{kNpy, 0, 1, write_npy};
constexpr const PixelFormat* kFormats[] = {&kJsonPixels, &kCsvPixels, &kPngPixels, &kNpyPixels};

}  // namespace

std::span<const PixelFormat* const> pixel_formats() {
    return kFormats;
}

}  // namespace ccdt::api
