// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <pybind11/pybind11.h>

#include "core/base/result.h"
#include "core/ccdt/surface/triangle_soup.h"

namespace ccdt::python {

/// Converts arrays to triangles.
/// @param arrays  vertices as float64 [n, 3], triangles as int64 [m, 3], sRGB colours as float64 [n, 3] with values
///                from 0 to 1, and texture coordinates as float64 [n, 2]. The last two may have no rows. All are in C
///                order.
/// Errors: Malformed for an index that is not that of a vertex, and for a colour out of range. Error::field names the
/// row: `triangles/3`.
Result<TriangleSoup> soup_of(const pybind11::tuple& arrays);

}  // namespace ccdt::python
