// SPDX-License-Identifier: GPL-3.0-or-later
#include "core/halftone/kind_areas.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "core/halftone/pixel_ranges.h"

namespace ccdt {

float relative_area(float cover, float visibility) {
    // Chosen by lightness errors of photographs after a blur of half a pitch. 0.03 to 0.1 are equally good.
    constexpr float kVisibility = 0.05f, kSmall = 1e-3f;
    const float contrast = cover * visibility / kVisibility;
    const float limit = kVisibility / visibility;  // area at cover 0
    return contrast < kSmall ? limit * (1 + contrast / 2) : cover / std::log(1 + contrast);
}

void normalize_areas(std::vector<KindOfDots>& kinds, Executor& executor) {
    float largest = 0;
    for (const KindOfDots& kind : kinds) {
        for (std::size_t i = 0; i < kind.area.size(); ++i) {
            if (kind.density[i] > 0) largest = std::max(largest, kind.area[i]);
        }
    }
    for (KindOfDots& kind : kinds) {
        for_pixels(executor, kind.area.size(),
                   [&](std::size_t i) { kind.area[i] = largest > 0 ? std::min(kind.area[i] / largest, 1.0f) : 1; });
    }
}

}  // namespace ccdt
