// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/base/line_transforms.h"

#include "core/base/lanes.h"
#include "core/base/pocketfft_lines.h"
#include "core/base/wide_line_transforms.h"

namespace ccdt {

const LineTransforms& common_line_transforms() {
    return kLineTransforms;
}

const LineTransforms& line_transforms() {
    const LineTransforms* const wide = wide_line_transforms();
    return wide != nullptr && has_two_lanes() ? *wide : kLineTransforms;
}

}  // namespace ccdt
