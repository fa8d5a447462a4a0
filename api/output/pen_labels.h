// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <string>
#include <vector>

#include "api/input/palette.h"

namespace ccdt::api {

/// Copies the inks of dots, of points or of a map's classes.
template <class Dots>
std::vector<Ink> inks_of(std::span<const Dots> dots) {
    std::vector<Ink> inks;
    for (const Dots& each : dots) inks.push_back(each.ink);
    return inks;
}

/// Labels pens for people, without digits: vpype takes the digits of a layer's label for its number, so `#ff0000` and
/// `#000000` would be one pen. Digits are left out of names, and an ink that is named by its colour gets a word for it.
/// Labels that would be alike get a letter each.
///
/// @returns  [inks]; UTF-8 as the names are
std::vector<std::string> pen_labels(std::span<const Ink> inks);

}  // namespace ccdt::api
