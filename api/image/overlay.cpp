// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/image/overlay.h"

#include <algorithm>
#include <array>
#include <span>
#include <utility>

#include "api/image/ink_set.h"
#include "api/image/srgb.h"
#include "core/halftone/pixel_ranges.h"

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

    /// Returns the light of an area on which all inks of a set are printed. Bit i stands for ink i.
    Light light_of(std::size_t inks) const {
        std::array<float, kMaxInks> cover{};
        for (std::size_t ink = 0; ink < inks_.inks.size(); ++ink) cover[ink] = static_cast<float>(inks >> ink & 1);
        return printed(inks_, std::span(cover).first(inks_.inks.size()));
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
    for_ranges(executor, picture.pixels.size(), kPixelsOfTask, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) picture.pixels[i] >>= 7;
    });
    return picture;
}

/// Computes the mean light of a pixel. Each ink has two shares of the pixel: the share in which the ground has the ink,
/// and the share in which dots flip the ink. The grounds of different inks are assumed to be independent of each other
/// and of the flipped areas. The flipped areas are assumed to be nested; see overlay_flipped().
class FlippedPixel {
public:
    FlippedPixel(std::size_t inks, const PrintedColour& colour_of) : inks_(inks) {
        for (std::size_t there = 0; there < std::size_t{1} << inks; ++there) lights_[there] = colour_of.light_of(there);
    }

    void set(std::span<const Raster> flipped, std::span<const Raster> grounds, std::size_t pixel) {
        light_ = {};
        bare_ = 0;
        for (std::size_t ink = 0; ink < inks_; ++ink) {
            flipped_[ink] = flipped[ink].coverage[pixel];
            ground_[ink] = grounds[ink].coverage[pixel];
            order_[ink] = ink;
        }
        // Insertion sort is fast here, because most pixels have dots of at most one kind. It is stable, so inks with
        // equal shares stay in order.
        for (std::size_t i = 1; i < inks_; ++i) {
            for (std::size_t j = i; j > 0 && flipped_[order_[j]] > flipped_[order_[j - 1]]; --j)
                std::swap(order_[j], order_[j - 1]);
        }
        add_grounds(0, 0, 1);
    }

    const Light& light() const { return light_; }
    float bare() const { return bare_; }

private:
    /// Adds the light of all combinations of grounds with and without the inks from `ink` on.
    /// @param ground  inks before `ink` that the ground has, as bits
    /// @param weight  share of the pixel that has exactly the ground `ground`
    void add_grounds(std::size_t ink, std::size_t ground, float weight) {
        if (ink == inks_) return add_parts(ground, weight);
        const unsigned share = ground_[ink];
        if (share < 255) add_grounds(ink + 1, ground, weight * static_cast<float>(255 - share) / 255);
        if (share > 0) add_grounds(ink + 1, ground | std::size_t{1} << ink, weight * static_cast<float>(share) / 255);
    }

    /// Adds the light of the part of a pixel whose ground has exactly the inks `there`. Divides this part into areas:
    /// in the first one no ink is flipped, in the second one order_[0], in the third one order_[0] and order_[1], and
    /// so on.
    void add_parts(std::size_t there, float weight) {
        unsigned upper = 255;
        for (std::size_t i = 0; i <= inks_; ++i) {
            const unsigned lower = i < inks_ ? flipped_[order_[i]] : 0;
            if (upper > lower) add(there, weight * static_cast<float>(upper - lower) / 255);
            upper = lower;
            if (i < inks_) there ^= std::size_t{1} << order_[i];
        }
    }

    void add(std::size_t there, float share) {
        const Light& light = lights_[there];
        light_ = {light_.red + share * light.red, light_.green + share * light.green, light_.blue + share * light.blue};
        if (there == 0) bare_ += share;
    }

    std::size_t inks_;
    std::array<Light, std::size_t{1} << kMaxInks> lights_{};
    std::array<unsigned, kMaxInks> flipped_{}, ground_{};
    std::array<std::size_t, kMaxInks> order_{};
    Light light_;
    float bare_ = 0;
};

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

DotImage overlay_flipped(std::span<const Raster> flipped, std::span<const Raster> grounds, const Palette& palette,
                         const std::stop_token& stop, Executor& executor) {
    const PrintedColour colour_of(palette);
    DotImage picture;
    picture.width = flipped.front().width;
    picture.height = flipped.front().height;
    picture.transparent = palette.paper.transparent;
    const std::size_t pixels = flipped.front().coverage.size(), channels = picture.channels();
    picture.pixels.resize(pixels * channels);
    for_ranges(executor, pixels, kPixelsOfTask, [&](std::size_t begin, std::size_t end) {
        if (stop.stop_requested()) return;
        FlippedPixel pixel(flipped.size(), colour_of);
        for (std::size_t i = begin; i < end; ++i) {
            pixel.set(flipped, grounds, i);
            std::copy_n(colour_of(pixel.light(), pixel.bare()).begin(), channels,
                        picture.pixels.begin() + static_cast<std::ptrdiff_t>(i * channels));
        }
    });
    return picture;
}

}  // namespace ccdt::api
