// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "core/base/elementary.h"

namespace ccdt {

/// Converts an sRGB value in [0, 1] to linear light in [0, 1] (IEC 61966-2-1).
template <class Number>
Number light_of_srgb(Number value) {
    return value <= Number(0.04045) ? value / Number(12.92)
                                    : elementary::pow((value + Number(0.055)) / Number(1.055), Number(2.4));
}

/// Converts linear light to an sRGB value; the inverse of light_of_srgb().
inline double srgb_of_light(double light) {
    return light <= 0.0031308 ? 12.92 * light : 1.055 * elementary::pow(light, 1 / 2.4) - 0.055;
}

/// Returns the light of a partly transparent colour on a ground, as viewers show it: they mix sRGB values.
/// @param light  linear light of the colour, in [0, 1]
/// @param value  sRGB value of the ground, in [0, 1]
/// @param alpha  in [0, 1]; 1: opaque
inline float displayed_light(float light, float value, float alpha) {
    if (alpha >= 1) return light;
    const auto own = static_cast<float>(srgb_of_light(static_cast<double>(light)));
    return light_of_srgb(value + alpha * (own - value));
}

/// Returns the relative luminance of linear light with the primaries of sRGB.
template <class Number>
Number luminance_of(Number red, Number green, Number blue) {
    return Number(0.2126) * red + Number(0.7152) * green + Number(0.0722) * blue;
}

}  // namespace ccdt
