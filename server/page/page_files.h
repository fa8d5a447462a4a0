// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <string_view>

namespace ccdt::server {

/// A file of the page that is embedded in the program.
struct PageFile {
    std::string_view path;  ///< path of the URL
    std::string_view media_type;
    std::string_view digest;  ///< digest of the content, used as its entity tag
    std::string_view content;
};

/// Returns all files of the page. embed.cmake generates the definition during the build.
std::span<const PageFile> page_files();

}  // namespace ccdt::server
