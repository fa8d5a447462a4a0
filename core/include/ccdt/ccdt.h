// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

/// @file
/// The library libccdt: evenly spread points, halftones of pictures in memory, and analysis of points.
///
///     const auto points = ccdt::sample(ccdt::Torus{1, 1}, 1000).points;
///
/// The interface consists of plain structs and functions that throw Exception. It includes the standard library only.
/// The interface is narrow, because the types that the library uses inside change between versions and include third
/// parties. These types also live in the namespace ccdt and have the same names. So the types of this interface live in
/// the namespace ccdt::v2, which appears in the names of symbols, and which users need not write.
///
/// Compatibility. The version of the shared library is libccdt.so.2. All versions 2.x accept programs that were built
/// with an older version 2.y: no struct, enumerator, function or default argument changes or disappears. Later versions
/// may add functions, types, enumerators and headers. Points and dots may improve with a new version, so they are the
/// same for the same version only. A version 3 will have the namespace ccdt::v3 and the library libccdt.so.3, and both
/// can be loaded into one program. Programs must be built with C++20 or later and with the standard library of GCC.
///
/// Threads. All functions may be called from several threads at once. They keep no state between calls.

#include "ccdt/abi.h"
#include "ccdt/analysis.h"
#include "ccdt/control.h"
#include "ccdt/domain.h"
#include "ccdt/exception.h"
#include "ccdt/halftone.h"
#include "ccdt/sample.h"
#include "ccdt/volume.h"

namespace ccdt::v2 {

/// Returns the version of the library that the program runs with, such as "2.0.0".
CCDT_EXPORT const char* version() noexcept;

}  // namespace ccdt::v2
