// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <vector>

#include "core/base/executor.h"

namespace ccdt {

/// Smooths an image but keeps its edges. Computes the u that minimises strength * TV(u) + 1/2 |u - values|^2, where TV
/// is the isotropic total variation. The result is as accurate as `steps` iterations allow.
///
/// A disc of radius r loses 2 * strength / r of its contrast; a long straight edge loses nothing.
///
/// @param values    [width * height]
/// @param strength  > 0, in units of the values times pixels
/// @param steps     number of iterations, >= 1
/// Deterministic for any number of threads. O(pixels * steps); 20 bytes per pixel.
/// Source: Rudin, Osher, Fatemi 1992; solved by the dual method of Beck and Teboulle 2009, Fast gradient-based
/// algorithms for constrained total variation image denoising, algorithm FGP.
std::vector<float> denoised(const std::vector<float>& values, int width, int height, float strength, int steps,
                            Executor& executor = inline_executor());

}  // namespace ccdt
