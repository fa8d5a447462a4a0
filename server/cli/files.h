// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

#include "api/output/body.h"
#include "api/output/file_writer.h"
#include "core/base/result.h"
#include "server/cli/interruption.h"

namespace ccdt::server {

/// Name of standard input and of standard output.
inline constexpr std::string_view kStandardStream = "-";

/// Size of the pieces in which files are read.
inline constexpr std::size_t kFilePiece = std::size_t{1} << 16;

/// Reads a file, or standard input. The messages of errors do not contain the name.
/// @param memory      the memory limit; the file may have half of it, because a growing buffer needs the other half
/// @param check_head  checks the first kFilePiece bytes of a file that has more, which may have no end
/// Errors: Unsupported if the file cannot be read; LimitExceeded; the errors of `check_head`.
Result<std::string> read_file(const std::string& name, std::size_t memory,
                              const std::function<Result<void>(std::string_view head)>& check_head = {});

/// Returns the target that the user has named; `-` is standard output.
api::OutputTarget output_target(const std::string& name);

/// Checks that an output can be written. Errors: Internal.
Result<void> check_output(const std::string& name);

/// Writes an answer to a file or to standard output, as api::FileWriter does.
class OutputFile : public api::BodySink {
public:
    /// @param name          as given by the user; `-` for standard output
    /// @param interruption  removes the temporary file if the program is interrupted; must outlive this object
    OutputFile(const std::string& name, Interruption& interruption);
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
    bool has_failed() const { return has_failed_; }

    std::size_t written() const { return written_; }

private:
    Result<void> check(const std::error_code& failed);

    const std::string name_;
    Interruption& interruption_;
    std::optional<api::FileWriter> file_;
    std::size_t written_ = 0;
    bool has_failed_ = false;
};

}  // namespace ccdt::server
