// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/cli/files.h"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "server/processes/unique_fd.h"

namespace ccdt::server {
namespace {

/// Ends the program like a program that does not ignore SIGPIPE.
void end_by_broken_pipe() {
    std::signal(SIGPIPE, SIG_DFL);
    raise(SIGPIPE);
}

}  // namespace

api::OutputTarget output_target(const std::string& name) {
    if (name == kStandardStream) return {"standard output", false, STDOUT_FILENO};
    return api::find_output(name);
}

Result<std::string> read_file(const std::string& name, std::size_t memory,
                              const std::function<Result<void>(std::string_view head)>& check_head) {
    const bool is_standard = name == kStandardStream;
    const UniqueFd file(is_standard ? dup(STDIN_FILENO) : open(name.c_str(), O_RDONLY | O_CLOEXEC));
    if (!file) return failure(ErrorCode::Unsupported, std::strerror(errno));
    const std::size_t max_bytes = memory / 2;
    const auto too_large = [&] {
        return failure(ErrorCode::LimitExceeded,
                       "the file has more bytes than half of the limit (--memory), " + std::to_string(max_bytes));
    };
    struct stat status {};
    std::string bytes;
    if (fstat(file.get(), &status) == 0 && S_ISREG(status.st_mode)) {
        if (static_cast<std::size_t>(status.st_size) > max_bytes) return too_large();
        bytes.reserve(static_cast<std::size_t>(status.st_size) + kFilePiece);
    }
    bool is_checked = false;
    while (true) {
        const std::size_t size = bytes.size();
        bytes.resize(size + kFilePiece);
        const ssize_t count = read(file.get(), bytes.data() + size, kFilePiece);
        bytes.resize(size + static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
        if (count == 0) return bytes;
        if (bytes.size() > max_bytes) return too_large();
        if (count < 0 && errno != EINTR) return failure(ErrorCode::Unsupported, std::strerror(errno));
        if (is_checked || !check_head || bytes.size() < kFilePiece) continue;
        is_checked = true;
        if (auto checked = check_head(std::string_view(bytes).substr(0, kFilePiece)); !checked)
            return tl::unexpected(checked.error());
    }
}

Result<void> check_output(const std::string& name) {
    std::string file;
    const auto failed = api::check_output(output_target(name), file);
    if (!failed) return {};
    const std::string position = file == name ? "" : file + ": ";
    return failure(ErrorCode::Internal, "cannot write " + name + ": " + position + failed.message());
}

OutputFile::OutputFile(const std::string& name, Interruption& interruption)
    : name_(name == kStandardStream ? "standard output" : name),
      interruption_(interruption),
      file_(std::in_place, output_target(name)) {}

OutputFile::~OutputFile() {
    file_.reset();
    interruption_.release_file();
}

Result<void> OutputFile::check(const std::error_code& failed) {
    if (!failed) return {};
    has_failed_ = true;
    return failure(ErrorCode::Internal, "cannot write " + name_ + ": " + failed.message());
}

Result<void> OutputFile::begin(const api::Answer& /*head*/) {
    std::error_code failed;
    const auto open = [&] {
        failed = file_->open();
        return file_->temporary();
    };
    // A pipe may wait for its reader, which must not delay an interruption.
    if (file_->target().is_replaced)
        interruption_.create_file(open);
    else
        open();
    return check(failed);
}

Result<void> OutputFile::write(std::string_view piece) {
    const auto failed = file_->write(piece);
    if (failed == std::errc::broken_pipe) end_by_broken_pipe();
    written_ += piece.size();
    return check(failed);
}

Result<void> OutputFile::finish() {
    return check(file_->close());
}

}  // namespace ccdt::server
