// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "api/image/image_format.h"

namespace ccdt::api {

/// Colour information that a file contains, in addition to the conventions of its format.
struct ColourTags {
    /// Transfer function and primaries, as code numbers of ITU-T H.273. PNG stores them in the chunk cICP, AVIF and
    /// HEIC in the property colr of type nclx.
    struct CodePoints {
        std::uint8_t primaries = 0;
        std::uint8_t transfer = 0;
    };

    std::string profile;                    ///< complete ICC profile; empty: none
    std::optional<CodePoints> code_points;  ///< take precedence over the profile
    /// Chromaticities x, y of white, red, green and blue; used only if there is no profile.
    std::optional<std::array<double, 8>> primaries;
    std::optional<float> gamma = {};  ///< exponent that converts samples to light; used only if there is no profile
};

/// Maximum size of a profile in bytes. A longer profile is ignored.
inline constexpr std::size_t kLongestProfile = std::size_t{4} << 20;

/// Reads colour tags: the chunks cICP, iCCP, cHRM and gAMA of PNG, the segments APP2 of JPEG, the chunk ICCP of WebP,
/// the tag 34675 of TIFF, the property colr of AVIF and HEIC, and the BITMAPV5HEADER of BMP. Broken or incomplete tags
/// are ignored. Sources: PNG (ISO/IEC 15948, third edition), 11.3.2; ICC.1:2022, annex B; ISO/IEC 14496-12, 12.1.5.
ColourTags read_colour_tags(std::string_view bytes, ImageFormat format);

/// Returns whether a file may have a profile. Does not read the profile.
bool may_have_profile(std::string_view bytes, ImageFormat format);

/// Returns a copy of the file in which OpenImageIO finds no profile, because OpenImageIO does not check profiles.
/// Returns an empty string if OpenImageIO finds no profile in the file itself.
std::string hide_profile(std::string_view bytes, ImageFormat format);

}  // namespace ccdt::api
