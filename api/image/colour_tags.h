// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "api/image/image_header.h"

namespace ccdt::api {

/// Colour information that a file contains, besides what follows from its format.
struct ColourTags {
    /// Transfer function and primaries by their numbers in ITU-T H.273, as in the chunk cICP of a PNG and in an AVIF's
    /// property colr of the type nclx.
    struct CodePoints {
        std::uint8_t primaries = 0;
        std::uint8_t transfer = 0;
    };

    std::string profile;                             ///< ICC.1, complete; empty: none
    std::optional<CodePoints> code_points;           ///< take precedence over the profile
    std::optional<std::array<double, 8>> primaries;  ///< x, y of white, red, green, blue; used without a profile
};

/// Size of the longest profile that is read; a longer one is ignored.
inline constexpr std::size_t kLongestProfile = std::size_t{4} << 20;

/// Reads colour tags: PNG's chunks cICP, iCCP, cHRM, JPEG's segments APP2, WebP's chunk ICCP, TIFF's tag 34675, AVIF's
/// property colr. Broken or incomplete tags are ignored.
/// Sources: PNG (ISO/IEC 15948, third edition), 11.3.2; ICC.1:2022, annex B; ISO/IEC 14496-12, 12.1.5.
ColourTags read_colour_tags(std::string_view bytes, ImageFormat format);

/// Returns whether a file may have a profile, without reading it.
bool may_have_profile(std::string_view bytes, ImageFormat format);

/// Copies the file so that OpenImageIO finds no profile, because it trusts profiles. Empty: it finds none in the file
/// itself.
std::string hide_profile(std::string_view bytes, ImageFormat format);

}  // namespace ccdt::api
