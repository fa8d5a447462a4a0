// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/cli/files.h"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace ccdt::server {
namespace {

std::string described(const std::string& name, int error) {
    return name + ": " + std::strerror(error);
}

/// Ends the program like a program that does not ignore SIGPIPE.
void end_by_broken_pipe() {
    std::signal(SIGPIPE, SIG_DFL);
    raise(SIGPIPE);
}

std::string folder_of(const std::string& path) {
    const auto folder = std::filesystem::path(path).parent_path();
    return folder.empty() ? "." : folder.string();
}

/// Returns the mode of a file that a program creates by default.
mode_t default_mode() {
    constexpr mode_t kAllMayReadAndWrite = 0666;
    const mode_t mask = umask(0);
    umask(mask);
    return kAllMayReadAndWrite & ~mask;
}

}  // namespace

std::string replaceable_path(const std::string& name) {
    std::error_code error;
    const auto path = std::filesystem::weakly_canonical(name, error);
    if (error) return name;
    const auto status = std::filesystem::status(path, error);
    const bool is_special = std::filesystem::exists(status) && !std::filesystem::is_regular_file(status);
    return is_special ? std::string() : path.string();
}

Result<std::string> read_file(const std::string& name, std::size_t max_bytes) {
    constexpr std::size_t kPiece = std::size_t{1} << 16;
    const bool is_standard = name == kStandardStream;
    const UniqueFd file(is_standard ? dup(STDIN_FILENO) : open(name.c_str(), O_RDONLY | O_CLOEXEC));
    if (!file) return failure(ErrorCode::Unsupported, std::strerror(errno));
    struct stat status {};
    std::string bytes;
    if (fstat(file.get(), &status) == 0 && S_ISREG(status.st_mode))
        bytes.reserve(std::min(static_cast<std::size_t>(status.st_size), max_bytes) + kPiece);
    while (true) {
        const std::size_t size = bytes.size();
        bytes.resize(size + kPiece);
        const ssize_t count = read(file.get(), bytes.data() + size, kPiece);
        bytes.resize(size + static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
        if (count == 0) return bytes;
        if (bytes.size() > max_bytes)
            return failure(ErrorCode::LimitExceeded,
                           "the file has more bytes than the limit (--memory), " + std::to_string(max_bytes));
        if (count < 0 && errno != EINTR) return failure(ErrorCode::Unsupported, std::strerror(errno));
    }
}

Result<void> check_output(const std::string& name) {
    if (name == kStandardStream) return {};
    const auto refuse = [&](const std::string& path, int error) {
        return failure(ErrorCode::Internal, "cannot write " + name + ": " + described(path, error));
    };
    const std::string target = replaceable_path(name);
    if (target.empty()) {
        if (std::filesystem::is_directory(name)) return refuse(name, EISDIR);
        if (access(name.c_str(), W_OK) != 0) return refuse(name, errno);
        return {};
    }
    const std::string folder = folder_of(target);
    if (access(folder.c_str(), W_OK | X_OK) != 0) return refuse(folder, errno);
    return {};
}

OutputFile::OutputFile(std::string name, Interruption& interruption)
    : name_(std::move(name)), interruption_(interruption) {}

OutputFile::~OutputFile() {
    if (temporary_.empty()) return;
    unlink(temporary_.c_str());
    interruption_.release_file();
}

tl::unexpected<Error> OutputFile::fail(int error) {
    failed_ = true;
    return failure(ErrorCode::Internal,
                   "cannot write " + described(name_ == kStandardStream ? "standard output" : name_, error));
}

Result<void> OutputFile::open_temporary() {
    // Independent of the name of the file, which may have the maximum length.
    std::string pattern = std::filesystem::path(target_).replace_filename(".ccdt.XXXXXX");
    temporary_ = interruption_.create_file([&] {
        file_ = UniqueFd(mkostemp(pattern.data(), O_CLOEXEC));
        return file_ ? pattern : std::string();
    });
    if (!file_) return fail(errno);
    struct stat existing {};
    fchmod(file_.get(), stat(target_.c_str(), &existing) == 0 ? existing.st_mode & 07777 : default_mode());
    return {};
}

Result<void> OutputFile::begin(const api::Answer& /*head*/) {
    if (name_ == kStandardStream) {
        file_ = UniqueFd(dup(STDOUT_FILENO));
    } else {
        target_ = replaceable_path(name_);
        if (!target_.empty()) return open_temporary();
        file_ = UniqueFd(open(name_.c_str(), O_WRONLY | O_CLOEXEC));
    }
    if (!file_) return fail(errno);
    return {};
}

Result<void> OutputFile::write(std::string_view piece) {
    while (!piece.empty()) {
        const ssize_t count = ::write(file_.get(), piece.data(), piece.size());
        if (count < 0 && errno == EINTR) continue;
        if (count < 0 && errno == EPIPE) end_by_broken_pipe();
        if (count < 0) return fail(errno);
        written_ += static_cast<std::size_t>(count);
        piece.remove_prefix(static_cast<std::size_t>(count));
    }
    return {};
}

Result<void> OutputFile::finish() {
    if (close(file_.release()) != 0) return fail(errno);
    if (temporary_.empty()) return {};
    if (rename(temporary_.c_str(), target_.c_str()) != 0) return fail(errno);
    temporary_.clear();
    interruption_.release_file();
    return {};
}

}  // namespace ccdt::server
