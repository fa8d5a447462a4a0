// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "api/output/body.h"
#include "core/base/result.h"

namespace ccdt::api {

/// Media type of archives.
inline constexpr std::string_view kZipType = "application/zip";

/// A file in an archive.
struct ArchivedFile {
    std::string name;  ///< ASCII
    std::string bytes;
};

/// Writes files as a ZIP archive, without compression. Frees the bytes of each file once they are written. The same
/// files give the same bytes. Errors: LimitExceeded for more than 65,535 files or 4 GiB.
/// Source: PKWARE, APPNOTE.TXT, 4.3.
Result<void> write_archive(std::vector<ArchivedFile> files, Body& body);

/// Returns the files of an archive that write_archive() has written.
std::vector<ArchivedFile> read_archive(std::string_view archive);

}  // namespace ccdt::api
