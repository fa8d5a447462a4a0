// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "api/output/body.h"
#include "core/result.h"
#include "server/cli/interruption.h"
#include "server/processes/unique_fd.h"

namespace ccdt::server {

/// Name of standard input and of standard output.
inline constexpr std::string_view kStandardStream = "-";

/// Reads a file, or standard input. The messages of errors do not contain the name.
/// @param max_bytes  maximum size of the file: the memory limit
/// Errors: Unsupported if the file cannot be read; LimitExceeded.
Result<std::string> read_file(const std::string& name, std::size_t max_bytes);

/// Writes an answer to a file or to standard output.
///
/// A file is written under a temporary name in its folder, and replaces an existing file when it is complete. So other
/// programs never see a part of an answer. The mode of an existing file is kept. Devices, pipes and standard output are
/// written directly.
class OutputFile : public api::BodySink {
public:
    /// @param name          as given by the user; `-` for standard output
    /// @param interruption  removes the temporary file if the program is interrupted; must outlive this object
    OutputFile(std::string name, Interruption& interruption);
    /// Removes the temporary file unless finish() has succeeded.
    ~OutputFile() override;
    OutputFile(const OutputFile&) = delete;
    OutputFile& operator=(const OutputFile&) = delete;

    /// Opens the output: a temporary file, or the device, pipe or standard output itself.
    Result<void> begin(const api::Answer& head) override;
    /// Writes a piece. If the reader of a pipe is gone, ends the program by SIGPIPE.
    Result<void> write(std::string_view piece) override;

    /// Completes the file.
    Result<void> finish();

    /// Whether an error was returned. All errors are Internal, and their messages contain the name.
    bool has_failed() const { return failed_; }

    std::size_t written() const { return written_; }

private:
    tl::unexpected<Error> fail(int error);
    Result<void> open_temporary();

    const std::string name_;
    Interruption& interruption_;
    std::string target_;     ///< path of the file, with links resolved; empty: written directly
    std::string temporary_;  ///< empty: none
    UniqueFd file_;
    std::size_t written_ = 0;
    bool failed_ = false;
};

/// Returns the path of a regular file with links resolved, or of a file that does not exist yet; empty for any other
/// file, such as a device, a pipe or a folder.
std::string replaceable_path(const std::string& name);

/// Checks that a file can be created in its folder, or replaced. Errors: Internal.
Result<void> check_output(const std::string& name);

}  // namespace ccdt::server
