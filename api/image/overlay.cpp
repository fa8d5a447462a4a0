// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/image/overlay.h"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "api/image/ink_set.h"
#include "api/image/srgb.h"
#include "core/halftone/inks/ink_mixture.h"
#include "core/picture/pixel_ranges.h"

namespace ccdt::api {
namespace {

/// Computes the colour of a pixel from the share of it that each ink covers.
class PrintedColour {
public:
    explicit PrintedColour(const Palette& palette) : inks_(ink_set(palette)), transparent_(palette.paper.transparent) {}

    /// @param cover  [inks] in [0, 1]
    /// @returns      red, green, blue, alpha
    std::array<std::uint8_t, 4> operator()(std::span<const float> cover) const {
        float bare = 1;
        for (const float share : cover) bare *= 1 - share;
        return (*this)(printed(inks_, cover), bare);
    }

    /// @param light  mean light of the pixel
    /// @param bare   share of the pixel in which the paper is visible
    std::array<std::uint8_t, 4> operator()(const Light& light, float bare) const {
        if (!transparent_) return {store(light.red), store(light.green), store(light.blue), 255};
        const auto alone = [bare](float seen) { return bare < 1 ? (seen - bare) / (1 - bare) : 1; };
        return {store(alone(light.red)), store(alone(light.green)), store(alone(light.blue)),
                static_cast<std::uint8_t>(255 * (1 - bare) + 0.5F)};
    }

private:
    /// Number of steps of light, large enough that results differ from to_srgb() by rounding only.
    static constexpr std::size_t kSteps = 1 << 16;

    /// Returns a table of the results of to_srgb(), which is computed once, because this takes some time.
    static const std::vector<std::uint8_t>& table() {
        static const std::vector<std::uint8_t> values = [] {
            std::vector<std::uint8_t> stored(kSteps);
            for (std::size_t i = 0; i < kSteps; ++i) stored[i] = to_srgb(static_cast<double>(i) / (kSteps - 1));
            return stored;
        }();
        return values;
    }

    std::uint8_t store(float light) const {
        return stored_[static_cast<std::size_t>(std::clamp(light, 0.0F, 1.0F) * (kSteps - 1) + 0.5F)];
    }

    InkSet inks_;
    bool transparent_;
    const std::vector<std::uint8_t>& stored_ = table();
};

/// Fills the palette of a picture in which each ink covers a pixel completely or not at all. Bit i of a pixel's value
/// is set if ink i covers the pixel.
void fill_palette(DotImage& picture, std::size_t inks, const PrintedColour& colour_of) {
    picture.colours = std::size_t{1} << inks;
    for (std::size_t code = 0; code < picture.colours; ++code) {
        std::array<float, kMaxInks> cover{};
        for (std::size_t ink = 0; ink < inks; ++ink) cover[ink] = static_cast<float>(code >> ink & 1);
        picture.palette[code] = colour_of(std::span(cover).first(inks));
    }
}

void fill_codes(std::span<const Raster> rasters, std::size_t begin, std::size_t end, DotImage& picture) {
    for (std::size_t ink = 0; ink < rasters.size(); ++ink) {
        const auto bit = static_cast<std::uint8_t>(1U << ink);
        for (std::size_t i = begin; i < end; ++i) {
            if (rasters[ink].coverage[i] != 0) picture.pixels[i] |= bit;
        }
    }
}

void fill_colours(std::span<const Raster> rasters, std::size_t begin, std::size_t end, const PrintedColour& colour_of,
                  DotImage& picture) {
    std::array<float, kMaxInks> cover{};
    auto to = picture.pixels.begin() + static_cast<std::ptrdiff_t>(begin * picture.channels());
    for (std::size_t i = begin; i < end; ++i) {
        for (std::size_t ink = 0; ink < rasters.size(); ++ink)
            cover[ink] = static_cast<float>(rasters[ink].coverage[i]) / 255;
        const auto colour = colour_of(std::span(cover).first(rasters.size()));
        to = std::copy_n(colour.begin(), picture.channels(), to);
    }
}

bool is_grey(const Colour& colour) {
    return !colour.transparent && colour.red == colour.green && colour.green == colour.blue;
}

/// Covers the paper with one ink. The memory of the raster is reused for the pixels.
DotImage cover(Raster raster, const Palette& palette, bool antialias, Executor& executor) {
    const Colour& ink = palette.inks.front().colour;
    DotImage picture{raster.width,
                     raster.height,
                     palette.paper.transparent,
                     is_grey(ink) && is_grey(palette.paper),
                     antialias ? std::size_t{256} : std::size_t{2},
                     shades_of(ink, palette.paper),
                     std::move(raster.coverage)};
    if (antialias) return picture;
    picture.palette[1] = picture.palette[255];
    for_pixels(executor, picture.pixels.size(), [&](std::size_t i) { picture.pixels[i] >>= 7; });
    return picture;
}

}  // namespace

bool DotImage::is_bilevel() const {
    const std::array ends = {palette[0][0], palette[1][0]};
    return grey && colours == 2 && std::ranges::min(ends) == 0 && std::ranges::max(ends) == 255;
}

DotImage overlay(std::vector<Raster> rasters, const Palette& palette, bool antialias, const std::stop_token& stop,
                 Executor& executor) {
    if (palette.mixing == Mixing::Cover) return cover(std::move(rasters.front()), palette, antialias, executor);
    const PrintedColour colour_of(palette);
    DotImage picture;
    picture.width = rasters.front().width;
    picture.height = rasters.front().height;
    picture.transparent = palette.paper.transparent;
    if (!antialias) fill_palette(picture, rasters.size(), colour_of);
    picture.pixels.resize(rasters.front().coverage.size() * picture.channels());
    for_ranges(executor, rasters.front().coverage.size(), kPixelsOfTask, [&](std::size_t begin, std::size_t end) {
        if (stop.stop_requested()) return;
        if (antialias) {
            fill_colours(rasters, begin, end, colour_of, picture);
        } else {
            fill_codes(rasters, begin, end, picture);
        }
    });
    return picture;
}

DotImage overlay_sets(std::span<const Raster> boundaries, std::span<const unsigned> sets, const Palette& palette,
                      bool antialias, const std::stop_token& stop, Executor& executor) {
    const PrintedColour colour_of(palette);
    std::vector<Light> lights;
    for (const unsigned set : sets) lights.push_back(light_of_set(ink_set(palette), set));
    DotImage picture;
    picture.width = boundaries.front().width;
    picture.height = boundaries.front().height;
    picture.transparent = palette.paper.transparent;
    if (!antialias) fill_palette(picture, palette.inks.size(), colour_of);
    const std::size_t pixels = boundaries.front().coverage.size(), channels = picture.channels();
    picture.pixels.resize(pixels * channels);
    const auto mixed = [&](std::size_t pixel) {
        Light light;
        float bare = 0;
        for_sets(boundaries, pixel, [&](std::size_t set, unsigned covered) {
            const float share = static_cast<float>(covered) / 255;
            const auto& [red, green, blue] = lights[set];
            light = {light.red + share * red, light.green + share * green, light.blue + share * blue};
            if (sets[set] == 0) bare += share;
        });
        return colour_of(light, bare);
    };
    for_ranges(executor, pixels, kPixelsOfTask, [&](std::size_t begin, std::size_t end) {
        if (stop.stop_requested()) return;
        for (std::size_t i = begin; i < end; ++i) {
            if (antialias) {
                std::copy_n(mixed(i).begin(), channels,
                            picture.pixels.begin() + static_cast<std::ptrdiff_t>(i * channels));
            } else {
                for_sets(boundaries, i,
                         [&](std::size_t set, unsigned) { picture.pixels[i] = static_cast<std::uint8_t>(sets[set]); });
            }
        }
    });
    return picture;
}

}  // namespace ccdt::api
