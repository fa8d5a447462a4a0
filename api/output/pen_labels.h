// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <string>
#include <vector>

#include "api/input/palette.h"

namespace ccdt::api {

/// Returns copies of the inks of several sets of points, or of the classes of a dot map.
template <class Dots>
std::vector<Ink> inks_of(std::span<const Dots> dots) {
    std::vector<Ink> inks;
    for (const Dots& each : dots) inks.push_back(each.ink);
    return inks;
}

/// Makes readable labels of pens, without digits. The plotter program vpype reads the digits in the label of a layer as
/// the layer's number, so `#ff0000` and `#000000` might become the same pen. Digits are removed from names. An ink
/// whose name is its colour gets the name of the nearest common colour. Equal labels are distinguished by letters.
///
/// @returns  [inks]; valid UTF-8 if the names are
std::vector<std::string> pen_labels(std::span<const Ink> inks);

}  // namespace ccdt::api
