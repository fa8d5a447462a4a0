// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <system_error>

namespace ccdt::api {

/// A file to which an answer is written.
struct OutputTarget {
    std::string path;
    bool is_replaced = false;  ///< the path has no links, and names a regular file or a file to create
    int descriptor = -1;       ///< of this process; if it is given, it is written instead of the path
};

/// Finds the file to which an answer with this name must be written.
///
/// A regular file, or a new name in a folder, is replaced. A link to either stays, and its target is replaced or
/// created. Everything else is written directly: devices, pipes, sockets, files on which another file is mounted, and
/// all files in /proc, whose links the kernel does not follow by their text. So `/dev/stdout` and `/dev/fd/N` are the
/// open files of this process, even if these are regular files or deleted. Descriptors of this process are not opened
/// again, so that they are written at their own offset, and sockets can be written.
OutputTarget find_output(const std::string& name);

/// Checks whether a target can be written, as far as that is possible without changing it.
/// @param file  receives the path to which the error applies
std::error_code check_output(const OutputTarget& target, std::string& file);

/// Writes a file. A file that is replaced is written under a temporary name in its folder, and gets its name when it is
/// complete, so that other programs never see a part of it. It keeps the mode of the existing file.
///
/// Errors are those of the system. After an error, no function may be called.
class FileWriter {
public:
    /// @param is_interrupted  called when a signal interrupts a call of the system; if it returns true, the call fails
    ///                        with EINTR, otherwise it is repeated
    explicit FileWriter(OutputTarget target, std::function<bool()> is_interrupted = {});
    /// Removes the temporary file unless close() has succeeded.
    ~FileWriter();
    FileWriter(const FileWriter&) = delete;
    FileWriter& operator=(const FileWriter&) = delete;

    /// Opens the file. Waits for a reader of a named pipe.
    std::error_code open();

    /// Writes a piece. A pipe without a reader raises SIGPIPE.
    std::error_code write(std::string_view piece);

    /// Completes the file.
    std::error_code close();

    const OutputTarget& target() const { return target_; }

    /// Returns the path of the temporary file; empty if there is none.
    const std::string& temporary() const { return temporary_; }

private:
    std::error_code open_temporary();
    std::error_code wait_until_writable() const;
    bool is_repeated(int error) const;

    const OutputTarget target_;
    const std::function<bool()> is_interrupted_;
    std::string temporary_;
    int file_ = -1;
};

/// Writes a whole file.
std::error_code write_file(const std::string& name, std::string_view bytes, std::function<bool()> is_interrupted = {});

}  // namespace ccdt::api
