// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/halftone/device_picture.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "api/image/ink_set.h"
#include "api/input/drawing_options.h"
#include "api/input/negotiation.h"
#include "api/input/run_options.h"
#include "api/output/json_writer.h"
#include "api/output/stage_costs.h"
#include "api/run/stopwatch.h"
#include "core/dither/dither.h"
#include "core/dither/frame.h"
#include "core/dither/printed_spot.h"
#include "core/picture/crop.h"
#include "core/picture/pixel_ranges.h"

namespace ccdt::api {
namespace {

constexpr DeviceFormat kPngPixels{kPng, write_device_png};
constexpr DeviceFormat kBmpPixels{{"bmp", "BMP", "bmp", "image/bmp", ""}, write_bmp};
// Rows of pixels and ESC/POS have no registered media types.
constexpr DeviceFormat kRawPixels{{"raw", "Packed pixels", "bin", "application/octet-stream", ""}, write_packed_rows};
constexpr DeviceFormat kEscposPixels{{"escpos", "ESC/POS", "bin", "application/x-escpos", ""}, write_escpos};
constexpr const DeviceFormat* kFormats[] = {&kPngPixels, &kBmpPixels, &kRawPixels, &kEscposPixels};

constexpr Interval kSpots = {.min = kMinSpot, .max = kMaxSpot};

struct Draft {
    DeviceRequest request;
    std::optional<std::vector<Colour>> palette;
    DrawingOptions drawing;
};

Result<int> read_quarters(const Input& input) {
    static constexpr std::array<Choice<int>, 4> kTurns = {{{"0", 0}, {"90", 1}, {"180", 2}, {"270", 3}}};
    if (const auto degrees = read_integer(input, 0, 270); degrees && *degrees % 90 == 0)
        return static_cast<int>(*degrees / 90);
    return read_choice<int>(input, kTurns);
}

Result<bool> read_bit_order(const Input& input) {
    static constexpr std::array<Choice<bool>, 2> kOrders = {{{"msb", false}, {"lsb", true}}};
    return read_choice<bool>(input, kOrders);
}

constexpr std::array<OptionRule<Draft>, 16> kRules = {{
    {"device", [](const Input& i, const Limits&, Draft& d) { return assign(d.request.device, read_device(i)); }},
    {"palette", [](const Input& i, const Limits&, Draft& d) { return assign(d.palette, read_device_colours(i)); }},
    {"width", [](const Input& i, const Limits&, Draft& d) { return assign(d.request.width, read_side(i)); }},
    {"height", [](const Input& i, const Limits&, Draft& d) { return assign(d.request.height, read_side(i)); }},
    {"fit", [](const Input& i, const Limits&, Draft& d) { return assign(d.request.fit, read_fit(i)); }},
    {"gravity", [](const Input& i, const Limits&, Draft& d) { return assign(d.request.gravity, read_gravity(i)); }},
    {"rotate", [](const Input& i, const Limits&, Draft& d) { return assign(d.request.quarters, read_quarters(i)); }},
    {"background",
     [](const Input& i, const Limits&, Draft& d) { return assign(d.request.background, read_colour(i)); }},
    {"alpha", [](const Input& i, const Limits&, Draft& d) { return assign(d.request.alpha, read_alpha(i)); }},
    {"levels", [](const Input& i, const Limits&, Draft& d) { return assign(d.request.levels, read_levels(i)); }},
    {"spot", [](const Input& i, const Limits&, Draft& d) { return assign(d.request.spot, read_number(i, kSpots)); }},
    {"width_mm", [](const Input& i, const Limits&, Draft& d) { return read_width_mm(i, d.drawing); }},
    {"bit_order",
     [](const Input& i, const Limits&, Draft& d) { return assign(d.request.pixels.lsb_first, read_bit_order(i)); }},
    {"invert_bits",
     [](const Input& i, const Limits&, Draft& d) { return assign(d.request.pixels.inverted, read_boolean(i)); }},
    {"on_deadline",
     [](const Input& i, const Limits&, Draft& d) { return assign(d.request.on_deadline, read_on_deadline(i)); }},
    {"format", [](const Input& i, const Limits&,
                  Draft& d) { return assign(d.request.format, read_format(i, device_formats())); }},
}};

/// Sets the colours of the device `custom`.
Result<void> settle_colours(Draft& draft, const HalftoneInput& input) {
    Device& device = draft.request.device;
    const bool is_custom = device.sent.empty();
    if (draft.palette && !is_custom)
        return malformed(input.option("palette"), "is the list of colours of device=custom only");
    if (!draft.palette && is_custom)
        return malformed(input.option("device"), "is custom, so palette is needed: the list of its colours");
    if (is_custom) device.sent = device.seen = *std::move(draft.palette);
    return {};
}

Result<void> check_formats(const DeviceRequest& request, const HalftoneInput& input) {
    for (const std::string_view option : {"bit_order", "invert_bits"}) {
        if (input.has(option) && request.format != &kRawPixels)
            return malformed(input.option(option), "is an option of format=raw only");
    }
    if (request.format == &kEscposPixels && request.device.sent.size() != 2) {
        const Input& cause = input.option(input.has("format") ? "format" : "device");
        return malformed(cause, "cannot be combined: ESC/POS printers need a device of two colours, such as 1bit");
    }
    return {};
}

Result<void> check_spot(const DeviceRequest& request, const HalftoneInput& input) {
    if (request.spot == 0 || request.device.sent.size() == 2) return {};
    return malformed(input.option("spot"), "needs a device of two colours, such as 1bit");
}

Result<void> check_sides(const DeviceRequest& request, const HalftoneInput& input) {
    if (auto fitting = check_gravity(input.options, request.fit); !fitting) return fitting;
    if (!input.has("fit") || (request.width && request.height)) return {};
    return malformed(input.option("fit"), "needs width and height");
}

FrameSize size_of_picture(const DeviceRequest& request) {
    const auto width = static_cast<int>(request.image.header.width),
               height = static_cast<int>(request.image.header.height);
    return request.quarters % 2 == 1 ? FrameSize{height, width} : FrameSize{width, height};
}

/// Scales a length by to / from, rounded to at least one pixel.
int scaled(int length, int to, int from) {
    constexpr double kMaxSide = 1 << 30;
    return static_cast<int>(std::clamp(std::round(static_cast<double>(length) * to / from), 1.0, kMaxSide));
}

/// Returns the size of the answer in pixels, for a picture of the given size.
FrameSize frame_of(const DeviceRequest& request, const FrameSize& picture) {
    if (request.width && request.height) return {*request.width, *request.height};
    if (request.width) return {*request.width, scaled(picture.height, *request.width, picture.width)};
    if (request.height) return {scaled(picture.width, *request.height, picture.height), *request.height};
    return picture;
}

double pixels_of(const FrameSize& size) {
    return static_cast<double>(size.width) * size.height;
}

/// Returns the largest size with the aspect ratio of a picture that fits into a frame.
FrameSize contained(const FrameSize& picture, const FrameSize& frame) {
    const FrameSize by_width{frame.width, scaled(picture.height, frame.width, picture.width)};
    if (by_width.height <= frame.height) return by_width;
    return {std::min(scaled(picture.width, frame.height, picture.height), frame.width), frame.height};
}

std::vector<Light> light_of(std::span<const Colour> colours) {
    std::vector<Light> light;
    for (const Colour& colour : colours) light.push_back(light_of(colour));
    return light;
}

/// Turns the picture, scales it into the frame, and returns the light of each pixel of the answer.
LightPlanes to_frame(ColourPicture picture, const DeviceRequest& request, Executor& executor) {
    picture = turned(with_levels(picture, request.levels, executor), request.quarters);
    const FrameSize frame = frame_of(request, {picture.width, picture.height});
    if (request.fit == Fit::Cover) {
        const FrameSize part = contained(frame, {picture.width, picture.height});
        picture = part_around(picture, part.width, part.height, request.gravity);
        return framed(picture, frame, frame, light_of(request.background), executor);
    }
    return framed(picture, contained({picture.width, picture.height}, frame), frame, light_of(request.background),
                  executor);
}

/// Returns, for each pixel, the index in `sent` of the colour that equals the pixel, or kAnyColour if there is none.
std::vector<std::uint8_t> exact_pixels(const LightPlanes& light, std::span<const Light> sent, Executor& executor) {
    constexpr float kTolerance = 1e-4f;  // less than half the difference in light between any two 8-bit sRGB values
    std::vector<std::uint8_t> given(light.front().size(), kAnyColour);
    for_pixels(executor, given.size(), [&](std::size_t i) {
        for (std::size_t number = 0; number < sent.size(); ++number) {
            const Light& colour = sent[number];
            if (std::abs(light[0][i] - colour.red) < kTolerance && std::abs(light[1][i] - colour.green) < kTolerance &&
                std::abs(light[2][i] - colour.blue) < kTolerance)
                given[i] = static_cast<std::uint8_t>(number);
        }
    });
    return given;
}

Result<void> check_size(const DeviceRequest& request, const FrameSize& frame, const Limits& limits) {
    constexpr double kUnsized = 4e6;  // takes up to half a minute; devices have fewer pixels
    if (!request.width && !request.height && pixels_of(frame) > kUnsized)
        return failure(ErrorCode::LimitExceeded,
                       "width is missing: without width and height, the answer would have the " +
                           std::to_string(frame.width) + " x " + std::to_string(frame.height) +
                           " pixels of the picture; the limit for this is 4000000",
                       request.image_field.empty() ? "width" : pointer_below("", "width"));
    if (pixels_of(frame) <= static_cast<double>(limits.max_pixels)) return {};
    const std::string option = request.width || !request.height ? "width" : "height";
    return failure(ErrorCode::LimitExceeded,
                   option + " makes an answer of " + std::to_string(frame.width) + " x " +
                       std::to_string(frame.height) + " pixels; this server's limit (max-pixels) is " +
                       std::to_string(limits.max_pixels),
                   request.image_field.empty() ? option : pointer_below("", option));
}

}  // namespace

std::span<const DeviceFormat* const> device_formats() {
    return kFormats;
}

std::vector<std::string_view> device_options() {
    return names_of<Draft>(kRules);
}

Result<DeviceRequest> parse_device(const HalftoneInput& input, std::string_view accept, const Limits& limits) {
    Draft draft;
    draft.request.image_field = input.image_field;
    if (auto read = read_options<Draft>(kRules, input.options, limits, draft); !read)
        return tl::unexpected(read.error());
    draft.request.pixels.width_mm = draft.drawing.width_mm;
    ErrorList errors;
    errors.add(settle_format(accept, device_formats(), draft.request.format));
    errors.add(settle_colours(draft, input));
    if (draft.request.format != nullptr) errors.add(check_formats(draft.request, input));
    errors.add(check_spot(draft.request, input));
    errors.add(check_sides(draft.request, input));
    if (auto settled = errors.result(); !settled) return tl::unexpected(settled.error());
    auto request = with_image(Result<DeviceRequest>(std::move(draft.request)), input);
    if (!request) return request;
    if (auto fits = check_size(*request, frame_of(*request, size_of_picture(*request)), limits); !fits)
        return tl::unexpected(fits.error());
    return request;
}

Result<Answer> run_device(const DeviceRequest& request, const Limits& limits, const Decode& decode,
                          const Control& control, Timings& timings) {
    Stopwatch watch;
    Executor& executor = *control.executor;
    Reading reading(limits.max_pixels);
    if (request.alpha == AlphaMixing::Display) reading.ground = light_of(request.background);
    auto picture = decode.colour(request.image.bytes, reading, control.stop);
    timings.decode = watch.lap();
    if (!picture) return failure(picture.error().code, picture.error().message, request.image_field);
    Answer answer;
    answer.pixels = static_cast<std::size_t>(picture->width) * static_cast<std::size_t>(picture->height);
    // Sizes are determined again here, because only decoding reveals the orientation of a photograph.
    const bool swaps = request.quarters % 2 == 1;
    const FrameSize frame = frame_of(
        request, swaps ? FrameSize{picture->height, picture->width} : FrameSize{picture->width, picture->height});
    if (auto fits = check_size(request, frame, limits); !fits) return tl::unexpected(fits.error());
    const LightPlanes light = to_frame(*std::move(picture), request, executor);
    timings.prepare = watch.lap();
    if (auto going = check_stop(control.stop); !going) return tl::unexpected(going.error());

    const std::vector<Light> seen = light_of(request.device.seen), sent = light_of(request.device.sent);
    const std::vector<std::uint8_t> given = exact_pixels(light, sent, executor);
    const std::vector<std::uint8_t> values =
        dither(light, given, frame.width, frame.height, seen, request.spot, control.stop, executor);
    timings.optimise = watch.lap();
    answer.partial = control.stop.stop_requested();
    if (answer.partial && request.on_deadline == OnStop::Error) return tl::unexpected(check_stop(control.stop).error());

    const DevicePixels pixels{frame.width,         frame.height, request.device.bits(), request.device.is_grey(),
                              request.device.sent, values};
    auto body = request.format->write(pixels, request.pixels, stop_of_writing(control, request.on_deadline));
    timings.encode = watch.lap();
    if (!body) return tl::unexpected(body.error());
    answer.body = *std::move(body);
    answer.media_type = request.format->file.content_type();
    if (std::string which = describe_frame(request.image.header); !which.empty())
        answer.warnings = write_warnings(std::array{Warning{request.image_field, std::move(which)}});
    return answer;
}

Cost cost_of(const DeviceRequest& request, const Limits& limits) {
    // Bytes per pixel of the answer: the wanted light and its copy, residuals, the levels of VisualError, and indices.
    constexpr double kBytes = 110;
    constexpr double kTime = 1.7 * kMicrosecond, kTimePerColour = 0.05 * kMicrosecond, kTimeOfSpots = 5 * kMicrosecond;
    constexpr double kPlanes = 3 * 16;  // bytes per pixel of the picture, its copy with levels, and its turned copy
    const double size =
        std::min(pixels_of(frame_of(request, size_of_picture(request))), static_cast<double>(limits.max_pixels));
    const double time = kTime + kTimePerColour * static_cast<double>(request.device.sent.size()) +
                        (request.spot > 0 ? kTimeOfSpots : 0);
    const Estimate search{size * kBytes, size * time};
    return total_cost(decoding_cost(request.image, kPlanes) + search);
}

std::size_t size_of(const DeviceRequest& request) {
    return bytes_of(request.image);
}

}  // namespace ccdt::api
