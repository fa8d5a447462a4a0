// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/fourier/line_transforms.h"

#include "core/fourier/pocketfft_lines.h"
#include "core/fourier/wide_line_transforms.h"
#include "core/geometry/lanes.h"

namespace ccdt {

const LineTransforms& common_line_transforms() {
    return kLineTransforms;
}

const LineTransforms& line_transforms() {
    const LineTransforms* const wide = wide_line_transforms();
    return wide != nullptr && has_two_lanes() ? *wide : kLineTransforms;
}

}  // namespace ccdt
