// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "server/page/page.h"

namespace ccdt::server {

/// Returns all files of the page. The build generates the source file: see embed.cmake.
std::span<const PageFile> page_files();

}  // namespace ccdt::server
