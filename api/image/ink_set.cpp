// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/image/ink_set.h"

#include "api/image/srgb.h"

namespace ccdt::api {

Light light_of(const Colour& colour) {
    return {static_cast<float>(to_linear(colour.red)), static_cast<float>(to_linear(colour.green)),
            static_cast<float>(to_linear(colour.blue))};
}

InkSet ink_set(const Palette& palette) {
    InkSet set;
    for (const Ink& ink : palette.inks) set.inks.push_back(light_of(ink.colour));
    set.paper = palette.paper.transparent ? Light{1, 1, 1} : light_of(palette.paper);
    set.additive = palette.mixing == Mixing::Add;
    return set;
}

}  // namespace ccdt::api
