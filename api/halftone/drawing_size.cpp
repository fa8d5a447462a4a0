// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/halftone/drawing_size.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "api/output/point_drawing.h"

namespace ccdt::api {
namespace {

Box box_of(PictureSize size) {
    return {{0, 0}, {static_cast<double>(size.width), static_cast<double>(size.height)}};
}

/// Rounds a length to whole pixels, at least one.
int to_pixels(double length) {
    return static_cast<int>(std::clamp(std::round(length), 1.0, double{std::numeric_limits<int>::max()}));
}

/// Returns a canvas of the given size that shows the drawn part of a picture completely. Its scale is the geometric
/// mean of the horizontal and the vertical scale.
Canvas showing(PictureSize part, int width, int height) {
    return {width, height, std::sqrt(static_cast<double>(width) / part.width * height / part.height)};
}

/// Returns the canvas of a request that gives width or height.
Canvas sized_canvas(const HalftoneRequest& request, PictureSize part) {
    const double across = static_cast<double>(request.width.value_or(0)) / part.width;
    const double down = static_cast<double>(request.height.value_or(0)) / part.height;
    if (request.width && request.height && request.fit == Fit::Cover)
        return showing(part, *request.width, *request.height);
    if (!request.height || (request.width && across <= down))
        return showing(part, *request.width, to_pixels(across * part.height));
    return showing(part, to_pixels(down * part.width), *request.height);
}

Canvas screen_canvas(PictureSize part, const Limits& limits) {
    constexpr double kWidth = 1280, kHeight = 800, kMinLength = 1000;
    const double fitting = std::min(kWidth / part.width, kHeight / part.height);
    const double wished = std::max(fitting, kMinLength / std::max(part.width, part.height));
    const Canvas canvas = canvas_of(box_of(part), fitting_scale(box_of(part), wished, limits.max_pixels));
    return showing(part, canvas.width, canvas.height);
}

}  // namespace

PictureSize drawn_part(const HalftoneRequest& request, PictureSize picture) {
    if (request.fit != Fit::Cover || !request.width || !request.height) return picture;
    const double aspect = static_cast<double>(*request.width) / *request.height;
    return {std::min(picture.width, to_pixels(picture.height * aspect)),
            std::min(picture.height, to_pixels(picture.width / aspect))};
}

std::optional<Canvas> settled_canvas(const HalftoneRequest& request, PictureSize part, const Limits& limits) {
    if (request.width || request.height) return sized_canvas(request, part);
    if (request.scale) return canvas_of(box_of(part), *request.scale);
    if (request.on_screen) return screen_canvas(part, limits);
    return std::nullopt;
}

Result<void> place_on_paper(const HalftoneRequest& request, Page& page) {
    return about_option(request, place_on_paper(request.drawing, page));
}

std::string size_option(const HalftoneRequest& request) {
    return request.drawing.dpi ? "dpi" : request.width ? "width" : request.height ? "height" : "scale";
}

Result<void> check_pixels(const HalftoneRequest& request, const Canvas& canvas, const Limits& limits) {
    if (fits(canvas, limits.max_pixels)) return {};
    const std::string option = size_option(request);
    return failure(ErrorCode::LimitExceeded,
                   option + " makes an output of " + std::to_string(canvas.width) + " x " +
                       std::to_string(canvas.height) + " pixels; this server's limit (max-pixels) is " +
                       std::to_string(limits.max_pixels),
                   option);
}

}  // namespace ccdt::api
