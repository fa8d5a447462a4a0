// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/pictures/picture_folder.h"

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

/// Makes the problem for a missing picture.
/// @param cause  for the log; empty: no log entry
tl::unexpected<Problem> no_picture(std::string cause = {}) {
    auto refused = problem(404, "there is no picture of this name");
    refused.value().cause = std::move(cause);
    return refused;
}

tl::unexpected<Problem> failed(const char* what, int error) {
    if (error == EMFILE || error == ENFILE || error == ENOMEM) return busy(503, "too many files are open", kRetryAfter);
    return problem(500, std::string(what) + ": " + std::strerror(error));
}

/// Makes the problem for a file that could not be opened. The client gets the same 404 for a missing file, a file that
/// is not regular, a name that the file system rejects, and a missing permission. The log names the missing permission.
tl::unexpected<Problem> not_opened(int error) {
    switch (error) {
        case ENOENT:
        case ELOOP:
        case ENOTDIR:
        case ENAMETOOLONG:
        case ENXIO:
        case EINVAL:
        case EILSEQ:
            return no_picture();
        case EACCES:
        case EPERM:
            return no_picture(std::string("the picture: ") + std::strerror(error));
        default:
            return failed("the picture cannot be opened", error);
    }
}

}  // namespace

bool is_picture_name(std::string_view name) {
    const auto is_control = [](char c) { return (c >= 0 && c < ' ') || c == 0x7f; };
    return !name.empty() && name.size() <= kMaxNameLength && !name.starts_with('.') &&
           name.find('/') == std::string_view::npos && std::ranges::none_of(name, is_control);
}

HttpResult<std::string> PictureFile::read() {
    const UniqueFd file = std::move(file_);
    std::string bytes(size_ + 1, '\0');  // one more byte, to detect a file that has grown
    std::size_t done = 0;
    while (done < bytes.size()) {
        const ssize_t count = ::read(file.get(), bytes.data() + done, bytes.size() - done);
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) return failed("the picture cannot be read", errno);
        if (count == 0) break;
        done += static_cast<std::size_t>(count);
    }
    if (done != size_) return busy(503, "the picture is being changed", kRetryAfter);
    bytes.resize(size_);
    return bytes;
}

UniqueFd PictureFolder::open_folder() const {
    return UniqueFd(::open(path_.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC));
}

Result<void> PictureFolder::check() const {
    const UniqueFd folder = open_folder();
    if (folder && faccessat(folder.get(), ".", X_OK, AT_EACCESS) == 0) return {};
    return failure(ErrorCode::Unusable, path_ + ": " + std::strerror(errno));
}

/// Opens only regular files directly in the folder. Because the name is a single path component, O_NOFOLLOW suffices;
/// container engines may forbid openat2. Checks the type before it opens a file, because opening a device can have
/// side effects.
HttpResult<PictureFile> PictureFolder::open(std::string_view name, std::size_t largest) const {
    if (!is_picture_name(name)) return no_picture();
    const UniqueFd folder = open_folder();
    if (!folder) return failed("the folder of pictures", errno);
    const std::string file_name(name);
    struct stat status {};
    if (fstatat(folder.get(), file_name.c_str(), &status, AT_SYMLINK_NOFOLLOW) != 0) return not_opened(errno);
    if (!S_ISREG(status.st_mode)) return no_picture();
    UniqueFd file(openat(folder.get(), file_name.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY | O_CLOEXEC));
    if (!file) return not_opened(errno);
    if (fstat(file.get(), &status) != 0) return failed("the picture", errno);
    if (!S_ISREG(status.st_mode)) return no_picture();
    const auto size = static_cast<std::size_t>(status.st_size);
    if (size > largest)
        return problem(413, "the picture is larger than the limit of " + std::to_string(largest) + " bytes (max-body)");
    return PictureFile(std::move(file), size);
}

}  // namespace ccdt::server
