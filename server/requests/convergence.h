// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

#include "api/run/options.h"

namespace ccdt::server {

/// Returns a remark for the log if an answer is good by its status, but its points are probably not spread as they
/// should be: at least 1,000 sites of /sample whose capacity variation is above 0.5 after at least 5 iterations.
/// Otherwise, returns an empty text.
///
/// Fewer sites, and halftones, may have a density with details finer than the distance of the sites, for which such a
/// variation is normal. With more sites, the measured variation was at most 0.4 for such densities, and at most 0.2 for
/// uniform ones.
/// @param path        path of the operation
/// @param iterations  number of completed iterations
/// @param variation   capacity variation after the last of them
std::string doubt_about(const api::Answer& answer, std::string_view path, int iterations, double variation);

}  // namespace ccdt::server
