// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <string>
#include <vector>

#include "api/input/palette.h"

namespace ccdt::api {

/// Makes readable labels of pens, without digits. The plotter program vpype reads the digits in the label of a layer as
/// the layer's number. So with the labels `#ff0000` and `#000000`, two layers could get the same pen. Digits are
/// removed from names. An ink whose name is its colour gets the name of the nearest common colour. Equal labels are
/// distinguished by letters.
///
/// @returns  [inks]; valid UTF-8 if the names of the inks are
std::vector<std::string> pen_labels(std::span<const Ink> inks);

}  // namespace ccdt::api
