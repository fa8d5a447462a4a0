// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

#include "api/output/body.h"
#include "api/output/page.h"

namespace ccdt::api {

/// Returns the number of decimals of coordinates in SVG: six significant digits at the longer side of the page.
int svg_decimals(const Page& page);

/// Begins an SVG document whose user units are those of the page.
/// @param attributes  additional attributes of the root element
void begin_svg(const Page& page, std::string_view attributes, Body& body);

/// Escapes a text for XML, also as the value of an attribute.
std::string escaped(std::string_view text);

}  // namespace ccdt::api
