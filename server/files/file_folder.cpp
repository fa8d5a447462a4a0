// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/files/file_folder.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace ccdt::server {
namespace {

constexpr std::size_t kMaxNameLength = 255;  // limit of Linux

/// Retry-After for temporary failures.
constexpr std::chrono::seconds kRetryAfter{1};

tl::unexpected<Problem> failed(const std::string& what, int error) {
    if (error == EMFILE || error == ENFILE || error == ENOMEM) return busy(503, "too many files are open", kRetryAfter);
    return problem(500, what + ": " + std::strerror(error));
}

}  // namespace

bool is_file_name(std::string_view name) {
    const auto is_control = [](char c) { return (c >= 0 && c < ' ') || c == 0x7f; };
    return !name.empty() && name.size() <= kMaxNameLength && !name.starts_with('.') &&
           name.find('/') == std::string_view::npos && std::ranges::none_of(name, is_control);
}

HttpResult<std::string> OpenFile::read() {
    const std::string what = "the " + std::string(noun_);
    const UniqueFd file = std::move(file_);
    std::string bytes(size_ + 1, '\0');  // one more byte, to detect a file that has grown
    std::size_t done = 0;
    while (done < bytes.size()) {
        const ssize_t count = ::read(file.get(), bytes.data() + done, bytes.size() - done);
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) return failed(what + " cannot be read", errno);
        if (count == 0) break;
        done += static_cast<std::size_t>(count);
    }
    if (done != size_) return busy(503, what + " is being changed", kRetryAfter);
    bytes.resize(size_);
    return bytes;
}

/// Makes the problem for a missing file.
/// @param cause  for the log; empty: no log entry
tl::unexpected<Problem> FileFolder::no_file(std::string cause) const {
    auto refused = problem(404, "there is no " + noun_ + " of this name");
    refused.value().cause = std::move(cause);
    return refused;
}

/// Makes the problem for a file that could not be opened. The client gets the same 404 for a missing file, a file that
/// is not regular, a name that the file system rejects, and a missing permission. The log names the missing permission.
tl::unexpected<Problem> FileFolder::not_opened(int error) const {
    switch (error) {
        case ENOENT:
        case ELOOP:
        case ENOTDIR:
        case ENAMETOOLONG:
        case ENXIO:
        case EINVAL:
        case EILSEQ:
            return no_file();
        case EACCES:
        case EPERM:
            return no_file("the " + noun_ + ": " + std::strerror(error));
        default:
            return failed("the " + noun_ + " cannot be opened", error);
    }
}

UniqueFd FileFolder::open_folder() const {
    return UniqueFd(::open(path_.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC));
}

Result<void> FileFolder::check() const {
    const UniqueFd folder = open_folder();
    if (folder && faccessat(folder.get(), ".", X_OK, AT_EACCESS) == 0) return {};
    return failure(ErrorCode::Unusable, path_ + ": " + std::strerror(errno));
}

/// Opens each folder of the path separately, because O_NOFOLLOW applies only to the last component of a path, and
/// container engines may forbid openat2.
HttpResult<OpenFile> FileFolder::open(std::string_view path, std::size_t largest) const {
    UniqueFd folder;
    while (true) {
        const auto slash = path.find('/');
        const std::string name(path.substr(0, slash));
        if (!is_file_name(name)) return no_file();
        if (!folder) folder = open_folder();
        if (!folder) return failed("the folder of " + noun_ + "s", errno);
        if (slash == std::string_view::npos) return open_in(folder.get(), name, largest);
        UniqueFd next(openat(folder.get(), name.c_str(), O_PATH | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
        if (!next) return not_opened(errno);
        folder = std::move(next);
        path.remove_prefix(slash + 1);
    }
}

/// Opens a regular file directly in a folder. Checks the type before it opens the file, because opening a device can
/// have side effects.
HttpResult<OpenFile> FileFolder::open_in(int folder, const std::string& name, std::size_t largest) const {
    struct stat status {};
    if (fstatat(folder, name.c_str(), &status, AT_SYMLINK_NOFOLLOW) != 0) return not_opened(errno);
    if (!S_ISREG(status.st_mode)) return no_file();
    UniqueFd file(openat(folder, name.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY | O_CLOEXEC));
    if (!file) return not_opened(errno);
    if (fstat(file.get(), &status) != 0) return failed("the " + noun_, errno);
    if (!S_ISREG(status.st_mode)) return no_file();
    const auto size = static_cast<std::size_t>(status.st_size);
    if (size > largest)
        return problem(
            413, "the " + noun_ + " is larger than the limit of " + std::to_string(largest) + " bytes (max-body)");
    return OpenFile(std::move(file), size, noun_);
}

}  // namespace ccdt::server
