// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/base/executor.h"
#include "core/halftone/inks/overprint.h"
#include "core/picture/picture.h"

namespace ccdt {

/// Returns a picture turned clockwise by `quarters` times 90 degrees.
/// @param quarters  0 to 3
ColourPicture turned(const ColourPicture& picture, int quarters);

/// Size of a picture in pixels, both sides >= 1.
struct FrameSize {
    int width = 0;
    int height = 0;

    friend bool operator==(const FrameSize&, const FrameSize&) = default;
};

/// Scales a picture and centres it in a frame.
///
/// Shrinks by exact means over cells, enlarges bilinearly between pixel centres; both in linear light, weighted by
/// alpha. A picture that has the size `inner` keeps its pixels exactly. Values outside [0, 1] are clamped, and NaN
/// counts as 0.
///
/// @param inner       size to which the picture is scaled; each side is at most that of the frame
/// @param background  light of transparent pixels and around the picture
/// @returns           red, green and blue [frame.width * frame.height]
/// Deterministic for any number of threads. O(pixels).
LightPlanes framed(const ColourPicture& picture, const FrameSize& inner, const FrameSize& frame,
                   const Light& background, Executor& executor = inline_executor());

}  // namespace ccdt
