// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>

#include "core/result.h"
#include "server/http/problem.h"
#include "server/processes/unique_fd.h"

namespace ccdt::server {

/// Whether a text may name a picture: 1 to 255 bytes without slashes, control characters and a leading dot.
bool is_picture_name(std::string_view name);

/// An open picture file.
class PictureFile {
public:
    PictureFile(UniqueFd file, std::size_t size) : file_(std::move(file)), size_(size) {}

    /// Size of the file in bytes when it was opened.
    std::size_t size() const { return size_; }

    /// Reads the whole file and closes it. Must be called at most once.
    /// Problems: 503 the size of the file has changed, 500 the file cannot be read.
    HttpResult<std::string> read();

private:
    UniqueFd file_;
    std::size_t size_;
};

/// A folder of pictures that clients request by name. Pictures are the regular files directly in the folder whose names
/// satisfy is_picture_name; links, subfolders and devices are not. The folder is never listed. Thread-safe.
class PictureFolder {
public:
    explicit PictureFolder(std::string path) : path_(std::move(path)) {}

    /// Checks that the folder exists and may be searched. Error: Unusable.
    Result<void> check() const;

    /// Opens a picture.
    ///
    /// @param largest  size limit of a picture, in bytes
    /// Problems: 404 for names of other files, 413, 503 if too many files are open, 500. No message contains a path.
    HttpResult<PictureFile> open(std::string_view name, std::size_t largest) const;

private:
    UniqueFd open_folder() const;

    const std::string path_;
};

}  // namespace ccdt::server
