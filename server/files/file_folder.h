// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>

#include "core/base/result.h"
#include "server/http/problem.h"
#include "server/processes/unique_fd.h"

namespace ccdt::server {

/// Whether a text may name a file: 1 to 255 bytes without slashes, control characters and a leading dot.
bool is_file_name(std::string_view name);

/// An open file of a FileFolder.
class OpenFile {
public:
    /// @param noun  name of the kind of file in messages, such as "picture"; must outlive this object
    OpenFile(UniqueFd file, std::size_t size, std::string_view noun)
        : file_(std::move(file)), size_(size), noun_(noun) {}

    /// Returns the size of the file in bytes when it was opened.
    std::size_t size() const { return size_; }

    /// Reads the whole file and closes it. Must be called at most once.
    /// Problems: 503 the size of the file has changed, 500 the file cannot be read.
    HttpResult<std::string> read();

private:
    UniqueFd file_;
    std::size_t size_;
    std::string_view noun_;
};

/// A folder of files that clients request by path. These are the regular files in the folder and its subfolders, if
/// each component of their paths satisfies is_file_name; links and devices are not. The folder is never listed.
/// Thread-safe.
class FileFolder {
public:
    /// @param noun  singular name of the files in messages, such as "picture"
    FileFolder(std::string path, std::string noun) : path_(std::move(path)), noun_(std::move(noun)) {}

    /// Checks that the folder exists and may be searched. Error: Unusable.
    Result<void> check() const;

    /// Opens a file, which must not outlive this folder.
    ///
    /// @param path     names separated by slashes
    /// @param largest  size limit of a file, in bytes
    /// Problems: 404 if the path names no such file, 413, 503 if too many files are open, 500. No message contains a
    /// path.
    HttpResult<OpenFile> open(std::string_view path, std::size_t largest) const;

private:
    UniqueFd open_folder() const;
    HttpResult<OpenFile> open_in(int folder, const std::string& name, std::size_t largest) const;
    tl::unexpected<Problem> no_file(std::string cause = {}) const;
    tl::unexpected<Problem> not_opened(int error) const;

    const std::string path_;
    const std::string noun_;
};

}  // namespace ccdt::server
