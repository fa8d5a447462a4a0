// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/output/file_writer.h"

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <utility>

#include <fcntl.h>
#include <linux/magic.h>
#include <poll.h>
#include <sys/stat.h>
#include <sys/statfs.h>
#include <unistd.h>

#include "api/text/text.h"

namespace ccdt::api {
namespace {

constexpr mode_t kAllMayReadAndWrite = 0666;

std::error_code error_of(int number) {
    return {number, std::generic_category()};
}

std::string folder_of(const std::filesystem::path& path) {
    const auto folder = path.parent_path();
    return folder.empty() ? "." : folder.string();
}

bool is_in_proc(const std::string& folder) {
    struct statfs status {};
    return statfs(folder.c_str(), &status) == 0 && status.f_type == PROC_SUPER_MAGIC;
}

/// Returns the open descriptor of this process that a path in /proc stands for; -1 if it stands for something else.
int own_descriptor(const std::filesystem::path& path) {
    // Open, so that the kernel keeps the number of its node.
    const int own = open("/proc/self/fd", O_PATH | O_DIRECTORY | O_CLOEXEC);
    if (own < 0) return -1;
    struct stat mine {
    }, named{};
    const bool is_own = fstat(own, &mine) == 0 && stat(folder_of(path).c_str(), &named) == 0 &&
                        mine.st_dev == named.st_dev && mine.st_ino == named.st_ino;
    close(own);
    const auto number = parse_number<int>(path.filename().string());
    return is_own && number && fcntl(*number, F_GETFD) >= 0 ? *number : -1;
}

/// Whether a path that is not a link names a regular file, or no file yet.
bool is_replaceable(const std::filesystem::path& path) {
    if (path.filename().empty()) return false;
    struct statx status {};
    if (statx(AT_FDCWD, path.c_str(), AT_SYMLINK_NOFOLLOW, STATX_TYPE, &status) != 0) return errno == ENOENT;
    return S_ISREG(status.stx_mode) && (status.stx_attributes & STATX_ATTR_MOUNT_ROOT) == 0;
}

}  // namespace

OutputTarget find_output(const std::string& name) {
    constexpr int kMaxLinks = 40;  // as in the kernel
    std::filesystem::path path = name;
    for (int links = 0; links <= kMaxLinks; ++links) {
        if (is_in_proc(folder_of(path))) return {name, false, own_descriptor(path)};
        std::error_code is_no_link;
        const auto next = std::filesystem::read_symlink(path, is_no_link);
        if (is_no_link) return is_replaceable(path) ? OutputTarget{path.string(), true} : OutputTarget{name};
        path = path.parent_path() / next;
    }
    return {name};
}

std::error_code check_output(const OutputTarget& target, std::string& file) {
    file = target.path;
    if (target.descriptor >= 0) {
        const int flags = fcntl(target.descriptor, F_GETFL);
        if (flags < 0) return error_of(errno);
        return error_of((flags & O_ACCMODE) == O_RDONLY ? EBADF : 0);
    }
    if (target.is_replaced) {
        file = folder_of(target.path);
        return error_of(access(file.c_str(), W_OK | X_OK) == 0 ? 0 : errno);
    }
    struct stat status {};
    if (stat(file.c_str(), &status) != 0) return error_of(errno);
    if (S_ISDIR(status.st_mode)) return error_of(EISDIR);
    if (S_ISSOCK(status.st_mode)) return error_of(ENXIO);
    return error_of(access(file.c_str(), W_OK) == 0 ? 0 : errno);
}

FileWriter::FileWriter(OutputTarget target, std::function<bool()> is_interrupted)
    : target_(std::move(target)), is_interrupted_(std::move(is_interrupted)) {}

FileWriter::~FileWriter() {
    if (file_ >= 0) ::close(file_);
    if (!temporary_.empty()) unlink(temporary_.c_str());
}

/// Whether a call of the system is to be repeated after an error.
bool FileWriter::is_repeated(int error) const {
    return error == EINTR && !(is_interrupted_ && is_interrupted_());
}

std::error_code FileWriter::open() {
    if (target_.path.find('\0') != std::string::npos) return error_of(EINVAL);
    if (target_.is_replaced) return open_temporary();
    do {
        file_ = target_.descriptor >= 0 ? fcntl(target_.descriptor, F_DUPFD_CLOEXEC, 0)
                                        : ::open(target_.path.c_str(), O_WRONLY | O_TRUNC | O_NOCTTY | O_CLOEXEC);
    } while (file_ < 0 && is_repeated(errno));
    return error_of(file_ < 0 ? errno : 0);
}

std::error_code FileWriter::open_temporary() {
    static std::atomic<unsigned> count = 0;
    std::string path;
    do {
        // Independent of the name of the file, which may have the maximum length.
        const std::string name = ".ccdt-" + std::to_string(getpid()) + '-' + std::to_string(count++);
        path = std::filesystem::path(target_.path).replace_filename(name);
        file_ = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, kAllMayReadAndWrite);
    } while (file_ < 0 && errno == EEXIST);
    if (file_ < 0) return error_of(errno);
    temporary_ = std::move(path);
    struct stat existing {};
    if (stat(target_.path.c_str(), &existing) == 0) fchmod(file_, existing.st_mode & 07777);
    return {};
}

/// Waits until a file that another program has made non-blocking accepts more bytes.
std::error_code FileWriter::wait_until_writable() const {
    pollfd waiting{file_, POLLOUT, 0};
    while (poll(&waiting, 1, -1) < 0) {
        if (!is_repeated(errno)) return error_of(errno);
    }
    return {};
}

std::error_code FileWriter::write(std::string_view piece) {
    while (!piece.empty()) {
        const ssize_t count = ::write(file_, piece.data(), piece.size());
        if (count >= 0) {
            piece.remove_prefix(static_cast<std::size_t>(count));
        } else if (errno == EAGAIN) {
            if (const auto failed = wait_until_writable()) return failed;
        } else if (!is_repeated(errno)) {
            return error_of(errno);
        }
    }
    return {};
}

std::error_code FileWriter::close() {
    if (::close(std::exchange(file_, -1)) != 0) return error_of(errno);
    if (temporary_.empty()) return {};
    if (std::rename(temporary_.c_str(), target_.path.c_str()) != 0) return error_of(errno);
    temporary_.clear();
    return {};
}

std::error_code write_file(const std::string& name, std::string_view bytes, std::function<bool()> is_interrupted) {
    FileWriter file(find_output(name), std::move(is_interrupted));
    if (const auto failed = file.open()) return failed;
    if (const auto failed = file.write(bytes)) return failed;
    return file.close();
}

}  // namespace ccdt::api
