// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "api/image/containers.h"

namespace ccdt::api {

/// Returns whether the first box of a file declares an AVIF, still or animated.
bool is_avif(std::string_view bytes);

/// Returns whether the first box of a file declares a HEIF other than an AVIF. Its pictures are usually coded in HEVC.
bool is_heic(std::string_view bytes);

/// Finds the properties of the primary item of a HEIF file, such as an AVIF. This item is the picture that the file
/// shows. Properties are boxes such as ispe (size), pixi (bits) and colr (colours). The result is empty if the file is
/// broken or ends too early. O(bytes). Source: HEIF (ISO/IEC 23008-12), 6 and 9.3.
std::vector<Chunk> heif_properties(std::string_view bytes);

/// The part of a picture that is shown, in pixels.
struct HeifView {
    std::uint32_t whole_width = 0, whole_height = 0;  ///< of the coded picture
    std::uint32_t left = 0, top = 0, width = 0, height = 0;
    int orientation = 1;  ///< orientation of EXIF that is equivalent to the rotations and mirrorings after the crop

    std::uint64_t whole_pixels() const { return std::uint64_t{whole_width} * whole_height; }
};

/// Returns the part of the primary item that its crop (clap) leaves, and how it is turned (irot, imir). A crop between
/// pixels is rounded down.
/// @param properties  see heif_properties()
/// @returns           none if the crop is not within the picture, or follows a rotation or a mirroring
/// Sources: ISO/IEC 14496-12, 12.1.4; HEIF, 6.5.10 and 6.5.12; MIAF (ISO/IEC 23000-22), 7.3.6.7 (order).
std::optional<HeifView> heif_view(std::span<const Chunk> properties);

/// Returns which grid of tiles the library for AVIF would misread, for an error message; empty if none. The library
/// ignores the alpha of single tiles, and takes tiles in the order of their items.
std::string_view misread_grid(std::string_view bytes);

/// Returns the types of the items of a HEIF file, such as hvc1 (a picture in HEVC) and grid. Types are of four letters
/// or digits; others are left out. Source: ISO/IEC 14496-12, 8.11.6.
std::vector<std::string_view> heif_item_types(std::string_view bytes);

/// Returns the number of frames in the first track of a HEIF file; 0 if the file has no track.
/// Source: ISO/IEC 14496-12, 8.7.3.
std::uint64_t heif_frames(std::string_view bytes);

}  // namespace ccdt::api
