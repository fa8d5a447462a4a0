// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/halftone/separated_picture.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <utility>

#include "api/halftone/drawing_size.h"
#include "api/halftone/halftone_cost.h"
#include "api/image/ink_set.h"
#include "api/run/deadline.h"
#include "core/halftone/dots/dots.h"
#include "core/halftone/field/field_plan.h"
#include "core/picture/crop.h"
#include "core/picture/fineness.h"
#include "core/picture/levels.h"
#include "core/picture/pixel_ranges.h"
#include "core/picture/reduction.h"
#include "core/picture/tone.h"

namespace ccdt::api {

double all_pixels(PictureSize size) {
    return static_cast<double>(size.width) * size.height;
}

tl::unexpected<Error> about_image(const Error& error, const HalftoneRequest& request) {
    return failure(error.code, error.message, request.image_field);
}

double picture_radius(const HalftoneRequest& request, PictureSize size, double scale) {
    return request.dot->millimetres ? request.dot->length / *request.drawing.width_mm * size.width
                                    : request.dot->length / scale;
}

bool has_screen_radius(const HalftoneRequest& request) {
    return request.on_screen && request.dots == Dots::Both && !request.sites && !request.dot;
}

double screen_radius(const Canvas& canvas, double fineness) {
    return radius_of_drawing(static_cast<double>(canvas.width) * canvas.height, fineness, kRadiusOfField) /
           canvas.scale;
}

double drawn_share(const std::vector<std::vector<float>>& coverage, const HalftoneRequest& request,
                   Executor& executor) {
    if (request.dots == Dots::Both) return minority_area(coverage, executor);
    double ink = 0;
    for (const auto& each : coverage) ink += sum_of(executor, each);
    return ink;
}

namespace {

/// Estimates the radius of dots, in pixels of the picture.
/// @param ink  area that dots cover, in pixels of the picture
double rough_radius(const HalftoneRequest& request, PictureSize size, double ink, double fineness,
                    const Limits& limits) {
    const double pixels = all_pixels(size);
    const std::size_t usual = request.sites ? *request.sites : usual_sites(request, size, ink, fineness, limits);
    const double drawn = request.dots == Dots::Both ? kDrawnShare * pixels : ink;
    const auto canvas = settled_canvas(request, size, limits);
    if (has_screen_radius(request)) return screen_radius(*canvas, fineness);
    if (request.sites || !request.dot) return std::sqrt(drawn / (std::numbers::pi * static_cast<double>(usual)));
    const double chosen = default_scale(ink, static_cast<std::size_t>(pixels), usual);
    return picture_radius(request, size, canvas ? canvas->scale : chosen);
}

/// Returns the cells in which a picture is separated: as fine as dots can show. The field of a drawing has no use for
/// cells that are smaller than the drawing's pixels.
CellGrid separation_cells(const HalftoneRequest& request, PictureSize size, double radius, const Limits& limits) {
    constexpr int kMin = 64;  // least number along a side
    CellGrid cells = resolved_cells(size.width, size.height, radius);
    const auto canvas = settled_canvas(request, size, limits);
    if (request.dots == Dots::Both && request.format->raster() != nullptr && canvas) {
        cells.columns = std::min(cells.columns, std::max(canvas->width, kMin));
        cells.rows = std::min(cells.rows, std::max(canvas->height, kMin));
    }
    return cells;
}

/// Returns the side, in pixels, of the squares of pixels that decoding may replace with their mean. Assumes that ink
/// covers at least a quarter of the picture, which makes dots too large to show the lost detail. Decoded::does_for()
/// checks this after decoding. Returns 1, which means no replacement, if a step before the separation is not linear in
/// the light of the pixels.
int reducible(const HalftoneRequest& request, const Limits& limits) {
    constexpr double kMinPixels = 4e6;  // fewer pixels take little time
    constexpr double kInk = 0.25;
    const auto width = static_cast<int>(request.image.header.width);
    const auto height = static_cast<int>(request.image.header.height);
    const PictureSize part = drawn_part(request, {width, height});
    const double pixels = all_pixels(part);
    const bool is_linear =
        request.levels == Levels{} && (request.palette.mixing != Mixing::Cover || request.tone != Tone::Perceptual);
    if (!is_linear || pixels < kMinPixels || (request.dot && !request.sites)) return 1;
    const std::size_t sites = request.sites ? *request.sites : usual_sites(request, part, pixels, 1, limits);
    const double radius = std::sqrt(kInk * pixels / (std::numbers::pi * static_cast<double>(sites)));
    const CellGrid cells = separation_cells(request, part, radius, limits);
    int side = std::min({part.width / cells.columns, part.height / cells.rows, Reading::kMaxReduced});
    while (width % side != 0 || height % side != 0) --side;
    return side;
}

/// The drawn part of a decoded picture. Each pixel of the decoded picture is the mean of a square of pixels in the
/// file; `side` is the side of this square.
template <class AnyPicture>
struct Decoded {
    Decoded(AnyPicture decoded, const HalftoneRequest& request, int reduced) : picture(std::move(decoded)) {
        const auto pixels = static_cast<std::uint64_t>(picture.width) * static_cast<std::uint64_t>(picture.height);
        const auto squares = static_cast<std::uint64_t>(reduced) * static_cast<std::uint64_t>(reduced);
        if (pixels * squares == request.image.header.pixels()) side = reduced;
        const PictureSize part = drawn_part(request, {picture.width, picture.height});
        if (part.width < picture.width || part.height < picture.height)
            picture = part_around(picture, part.width, part.height, request.gravity);
    }

    PictureSize size() const { return {side * picture.width, side * picture.height}; }
    CellGrid cells() const { return {picture.width, picture.height}; }

    /// Returns whether the decoded picture has enough detail for the dots. If each of its pixels is the mean of a
    /// square of pixels in the file, the separation must not need cells smaller than these squares, and the lost detail
    /// must not change the number of dots.
    /// @param wanted  cells of the separation
    /// @param ink     area that dots cover, in pixels of the file
    bool does_for(const CellGrid& wanted, const HalftoneRequest& request, double ink, const Limits& limits) const {
        if (side == 1) return true;
        if (wanted.columns > picture.width || wanted.rows > picture.height) return false;
        if (request.sites || request.on_screen) return true;
        return usual_sites(request, size(), ink, 0, limits) == usual_sites(request, size(), ink, 1, limits);
    }

    /// Returns the fineness of the picture, or 0 if it is unknown because of averaged squares. For drawings on screens,
    /// the fineness of the averaged picture is used, because screens would not show more detail.
    double detail(const HalftoneRequest& request, Executor& executor) const {
        return side > 1 && !request.on_screen ? 0 : fineness(picture, executor);
    }

    AnyPicture picture;
    int side = 1;
};

/// Separates a grey picture, whose dots have a single ink.
/// @returns  none if averaging pixels during decoding lost detail that the dots need
std::optional<SeparatedPicture> separate_grey(const Decoded<Picture>& decoded, const HalftoneRequest& request,
                                              const Limits& limits, Executor& executor) {
    const Picture& picture = decoded.picture;
    SeparatedPicture separated{decoded.size(), {}, {}, decoded.detail(request, executor)};
    std::vector<std::vector<float>> all = {ink_coverage(picture, request.tone, request.dots == Dots::Paper, executor)};
    const double ink = drawn_share(all, request, executor) * decoded.side * decoded.side;
    std::vector<float>& coverage = all.front();
    const double radius = rough_radius(request, separated.size, ink, separated.fineness, limits);
    separated.cells = separation_cells(request, separated.size, radius, limits);
    if (!decoded.does_for(separated.cells, request, ink, limits)) return std::nullopt;
    if (separated.cells != CellGrid{picture.width, picture.height})
        coverage = reduced(coverage, picture.width, picture.height, separated.cells, executor);
    separated.inks.coverage = std::move(all);
    return separated;
}

/// Separates a picture into inks or, for Dots::Both, into red, green and blue.
Separation separate(const ColourPicture& picture, const HalftoneRequest& request, const Control& control) {
    const InkSet inks = ink_set(request.palette);
    if (request.dots == Dots::Both) return {channel_coverage(picture, inks, request.tone, *control.executor), {}};
    return separate(picture, inks, request.tone, control.stop, *control.executor);
}

/// Estimates the area that the dots of all inks draw, in pixels of `picture`. Measures it on a small copy of the
/// picture.
double rough_ink(const ColourPicture& picture, const HalftoneRequest& request, const Control& control) {
    constexpr int kSide = 64;
    const CellGrid cells{std::min(picture.width, kSide), std::min(picture.height, kSide)};
    const Separation small = separate(reduced(picture, cells, *control.executor), request, control);
    const double ink = drawn_share(small.coverage, request, *control.executor);
    return ink / (static_cast<double>(cells.columns) * cells.rows) * picture.width * picture.height;
}

/// Separates a picture in colour.
/// @returns  none if averaging pixels during decoding lost detail that the dots need
std::optional<SeparatedPicture> separate_colours(Decoded<ColourPicture> decoded, const HalftoneRequest& request,
                                                 const Limits& limits, const Control& control) {
    Executor& executor = *control.executor;
    ColourPicture& picture = decoded.picture;
    SeparatedPicture separated{decoded.size(), {}, {}, decoded.detail(request, executor)};
    const double ink = rough_ink(picture, request, control) * decoded.side * decoded.side;
    const double radius = rough_radius(request, separated.size, ink, separated.fineness, limits);
    separated.cells = separation_cells(request, separated.size, radius, limits);
    if (!decoded.does_for(separated.cells, request, ink, limits)) return std::nullopt;
    if (separated.cells != CellGrid{picture.width, picture.height})
        picture = reduced(picture, separated.cells, executor);
    separated.inks = separate(picture, request, control);
    return separated;
}

/// Returns the ground that shows through transparent parts of the picture.
Light ground_of(const HalftoneRequest& request) {
    if (request.palette.mixing != Mixing::Cover) return ink_set(request.palette).paper;
    return light_of(request.dots == Dots::Paper ? kBlack : kWhite);
}

/// Decodes a picture and separates it into inks. For an opaque ink, decodes luminance only, which takes a third of the
/// memory of colours.
/// @param reduce  side of the squares that decoding may replace with their mean
/// @returns       none if averaging pixels lost detail that the dots need
Result<std::optional<SeparatedPicture>> separate_picture(const HalftoneRequest& request, const Limits& limits,
                                                         const Decode& decode, const Control& control, int reduce) {
    const ImageFile& file = request.image;
    Reading reading(limits.max_pixels, reduce);
    if (request.alpha == AlphaMixing::Display) reading.ground = ground_of(request);
    if (request.palette.mixing == Mixing::Cover) {
        auto picture = decode.grey(file.bytes, reading, control.stop);
        if (!picture) return about_image(picture.error(), request);
        picture = with_levels(*picture, request.levels, *control.executor);
        return separate_grey({*std::move(picture), request, reduce}, request, limits, *control.executor);
    }
    auto picture = decode.colour(file.bytes, reading, control.stop);
    if (!picture) return about_image(picture.error(), request);
    picture = with_levels(*picture, request.levels, *control.executor);
    auto separated = separate_colours({*std::move(picture), request, reduce}, request, limits, control);
    if (auto going = check_stop(control.stop); !going) return tl::unexpected(going.error());
    return separated;
}

}  // namespace

Result<SeparatedPicture> separate_picture(const HalftoneRequest& request, const Limits& limits, const Decode& decode,
                                          const Control& control) {
    const int reduce = reducible(request, limits);
    auto separated = separate_picture(request, limits, decode, control, reduce);
    if (separated && !*separated) separated = separate_picture(request, limits, decode, control, 1);
    return separated.map([](std::optional<SeparatedPicture>& picture) { return *std::move(picture); });
}

}  // namespace ccdt::api
