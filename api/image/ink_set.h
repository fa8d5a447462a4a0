#pragma once

#include "api/input/print.h"
#include "core/halftone/separation.h"

namespace ccdt::api {

/// What is printed with, in linear light.
InkSet ink_set(const Print& print);

}  // namespace ccdt::api
