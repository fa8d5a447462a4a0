#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "api/image/image_header.h"

namespace ccdt::api {

/// Colours of a file as it tells them, besides what goes with its format.
struct ColourTags {
    /// A transfer function and primaries by their numbers in ITU-T H.273, as a PNG's cICP has them, and an
    /// AVIF's colr of the type nclx.
    struct CodePoints {
        std::uint8_t primaries = 0;
        std::uint8_t transfer = 0;
    };

    std::string profile;                             ///< ICC.1, whole; empty: none
    std::optional<CodePoints> code_points;           ///< go before the profile
    std::optional<std::array<double, 8>> primaries;  ///< x, y of white, red, green, blue; used without a profile
};

/// Size of the longest profile that is read; a longer one counts as none.
inline constexpr std::size_t kLongestProfile = std::size_t{4} << 20;

/// Reads colours: PNG's chunks cICP, iCCP, cHRM, JPEG's segments APP2, WebP's chunk ICCP, TIFF's tag 34675, AVIF's
/// property colr. Whatever is broken or incomplete counts as not there.
/// Sources: PNG (ISO/IEC 15948, third edition), 11.3.2; ICC.1:2022, annex B; ISO/IEC 14496-12, 12.1.5.
ColourTags read_colour_tags(std::string_view bytes, ImageFormat format);

/// Tells whether there may be a profile, without a look at it.
bool may_have_profile(std::string_view bytes, ImageFormat format);

/// Copies the file to one in which OpenImageIO, whose reading of profiles trusts them, finds none. Empty: it finds none
/// in the file itself.
std::string hide_profile(std::string_view bytes, ImageFormat format);

}  // namespace ccdt::api
