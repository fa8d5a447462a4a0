// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "api/image/containers.h"

namespace ccdt::api {

/// Returns whether the first box of a file declares an AVIF, still or animated.
bool is_avif(std::string_view bytes);

/// Finds the properties of the primary item of an AVIF file, that is, of the picture that the file shows. Properties
/// are boxes such as ispe (size), pixi (bits) and colr (colours). The result is empty if the file is broken or ends too
/// early. O(bytes). Source: HEIF (ISO/IEC 23008-12), 6 and 9.3.
std::vector<Chunk> avif_properties(std::string_view bytes);

/// Returns the number of frames in the first track of an AVIF file; 0 if the file has no track.
/// Source: ISO/IEC 14496-12, 8.7.3.
std::uint64_t avif_frames(std::string_view bytes);

}  // namespace ccdt::api
