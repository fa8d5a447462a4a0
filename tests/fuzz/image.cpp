// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/image/image_codec.h"
#include "api/image/image_header.h"

#include <algorithm>
#include <cmath>

#include "tests/fuzz/checks.h"

namespace ccdt::fuzz {
namespace {

constexpr std::size_t kMaxPixels = 16'384;

bool is_share(float value) {
    return value >= 0 && value <= 1;
}

void check_picture(const Picture& picture, const api::ImageHeader& header) {
    CCDT_CHECK(picture.width > 0 && picture.height > 0);
    const auto pixels = static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height);
    CCDT_CHECK(pixels <= kMaxPixels);
    CCDT_CHECK(picture.luminance.size() == pixels);
    CCDT_CHECK(pixels == header.pixels());
    CCDT_CHECK(picture.alpha.empty() || picture.alpha.size() == pixels);
    CCDT_CHECK(std::ranges::all_of(picture.luminance, is_share));
    CCDT_CHECK(std::ranges::all_of(picture.alpha, is_share));
}

/// Checks that decoding a file again yields the same picture. Reads of uninitialized memory would change it.
void check_again(std::string_view file, const Picture& picture) {
    const auto again = api::decode_image(file, kMaxPixels);
    CCDT_CHECK(again && again->width == picture.width && again->height == picture.height);
    CCDT_CHECK(again->luminance == picture.luminance && again->alpha == picture.alpha);
}

/// Checks that decoding a file in colour yields the same luminance or the same error as in grey.
void check_colours(std::string_view file, const Result<Picture>& grey) {
    const auto colours = api::decode_colour_image(file, kMaxPixels);
    CCDT_CHECK(colours.has_value() == grey.has_value());
    if (!grey) {
        CCDT_CHECK(colours.error().code == grey.error().code && colours.error().message == grey.error().message);
        return;
    }
    CCDT_CHECK(colours->width == grey->width && colours->height == grey->height && colours->alpha == grey->alpha);
    for (const Plane* light : {&colours->red, &colours->green, &colours->blue}) {
        CCDT_CHECK(light->size() == grey->luminance.size() && std::ranges::all_of(*light, is_share));
    }
    for (std::size_t i = 0; i < grey->luminance.size(); ++i) {
        const float weighed = 0.2126F * colours->red[i] + 0.7152F * colours->green[i] + 0.0722F * colours->blue[i];
        CCDT_CHECK(std::abs(weighed - grey->luminance[i]) < 1e-5F);
    }
}

void check_refused(const Error& error, std::string_view file) {
    check_error(error);
    CCDT_CHECK(error.field.empty());
    const bool is_known = api::recognise_image(file).has_value();
    CCDT_CHECK(is_known == (error.code == ErrorCode::Unusable || error.code == ErrorCode::LimitExceeded));
}

}  // namespace
}  // namespace ccdt::fuzz

/// Decodes the input as a picture.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace ccdt;
    const auto file = fuzz::text_of(data, size);
    const auto picture = api::decode_image(file, fuzz::kMaxPixels);
    fuzz::check_colours(file, picture);
    if (picture) {
        fuzz::check_picture(*picture, *api::read_image_header(file, fuzz::kMaxPixels));
        fuzz::check_again(file, *picture);
    } else {
        fuzz::check_refused(picture.error(), file);
    }
    return 0;
}
