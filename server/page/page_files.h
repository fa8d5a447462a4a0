// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>

#include "server/page/page.h"

namespace ccdt::server {

/// Files of the page, all of them. The source is written by the build; see embed.cmake.
std::span<const PageFile> page_files();

}  // namespace ccdt::server
