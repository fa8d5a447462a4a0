// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include "api/run/options.h"
#include "core/base/result.h"

namespace ccdt::api {

/// Removes the option `object`, which selects a shapefile of an archive, from the options of a request. The remaining
/// options are those of the request with GeoJSON.
/// @returns  value of the option; empty if it is not given
/// Errors: Malformed if the option is given twice.
Result<std::string> take_object(std::vector<TextOption>& options);

}  // namespace ccdt::api
