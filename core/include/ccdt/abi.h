// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

/// Marks the functions and classes that the shared libraries export.
#define CCDT_EXPORT __attribute__((visibility("default")))

namespace ccdt {

/// The interface of libccdt and libccdt-api, version 2. All of it can also be named without `v2`.
namespace v2 {}

// Code of the library itself sees types of the same names in the namespace ccdt, and names these types with `v2`.
#ifndef CCDT_INTERNAL
using namespace v2;
#endif

}  // namespace ccdt
