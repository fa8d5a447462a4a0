#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>

#include "core/result.h"
#include "server/http/problem.h"
#include "server/processes/unique_fd.h"

namespace ccdt::server {

/// Whether a text may name a picture of a folder: it is one component of a path, of 1 to 255 bytes, none of them a
/// slash or a control character, and does not begin with a dot, as hidden files do.
bool is_picture_name(std::string_view name);

/// A picture's file, open.
class PictureFile {
public:
    PictureFile(UniqueFd file, std::size_t size) : file_(std::move(file)), size_(size) {}

    /// Bytes that it had when it was opened.
    std::size_t size() const { return size_; }

    /// Reads all of it and closes it; to be called once. Problems: 503 if it does not have that size any more, 500 if
    /// it cannot be read.
    HttpResult<std::string> read();

private:
    UniqueFd file_;
    std::size_t size_;
};

/// A folder whose pictures clients name. Only regular files in the folder itself are pictures: no links, no folders, no
/// devices, and nothing whose name is_picture_name refuses. The folder is never listed. May be used from any thread.
class PictureFolder {
public:
    explicit PictureFolder(std::string path) : path_(std::move(path)) {}

    /// Checks that the folder is there and may be searched. Errors: Unusable.
    Result<void> check() const;

    /// Opens the file of that name.
    ///
    /// @param largest  bytes that a picture may have
    /// Problems: 404 that is the same whatever else has that name, 413, 503 if too many files are open, 500. No message
    /// has a path.
    HttpResult<PictureFile> open(std::string_view name, std::size_t largest) const;

private:
    UniqueFd open_folder() const;

    const std::string path_;
};

}  // namespace ccdt::server
