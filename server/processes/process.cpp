// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/processes/process.h"

#include <malloc.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <string>
#include <string_view>

namespace ccdt::server {

std::size_t resident_bytes() {
    std::size_t all = 0, resident = 0;
    std::ifstream("/proc/self/statm") >> all >> resident;
    return resident * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

namespace {

constexpr std::size_t kNoLimit = std::numeric_limits<std::size_t>::max();

std::size_t limit_in(const std::filesystem::path& file) {
    std::size_t bytes = 0;
    return std::ifstream(file) >> bytes ? bytes : kNoLimit;  // "max" means no limit
}

/// Returns the path of this process' control group, relative to the mount point.
/// @param controllers  as in /proc/self/cgroup: "memory" for version 1, empty for version 2
std::filesystem::path group(std::string_view controllers) {
    std::ifstream file("/proc/self/cgroup");
    for (std::string line; std::getline(file, line);) {
        const auto first = line.find(':');
        const auto second = line.find(':', first + 1);
        if (second == std::string::npos) continue;
        if (std::string_view(line).substr(first + 1, second - first - 1) == controllers) return line.substr(second + 1);
    }
    return {};
}

/// Returns the lowest limit among this process' control group and the enclosing groups.
std::size_t limit_of_groups(const std::filesystem::path& root, std::string_view controllers, const char* name) {
    std::size_t limit = limit_in(root / name);
    auto inner = group(controllers).relative_path();
    for (; !inner.empty(); inner = inner.parent_path()) limit = std::min(limit, limit_in(root / inner / name));
    return limit;
}

}  // namespace

std::size_t available_memory() {
    const auto machine =
        static_cast<std::size_t>(sysconf(_SC_PHYS_PAGES)) * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
    return std::min({machine, limit_of_groups("/sys/fs/cgroup", "", "memory.max"),
                     limit_of_groups("/sys/fs/cgroup/memory", "memory", "memory.limit_in_bytes")});
}

std::optional<std::size_t> address_space_limit() {
    rlimit limit{};
    if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) return std::nullopt;
    return limit.rlim_cur;
}

void give_back_freed_memory(int bytes) {
    mallopt(M_MMAP_THRESHOLD, bytes);
    mallopt(M_TRIM_THRESHOLD, bytes);
}

void share_heap_among_threads() {
    mallopt(M_ARENA_MAX, 1);
}

std::chrono::microseconds processor_time() {
    timespec time{};
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
    return std::chrono::seconds(time.tv_sec) + std::chrono::microseconds(time.tv_nsec / 1000);
}

std::size_t open_descriptors() {
    std::error_code error;
    const std::filesystem::directory_iterator begin("/proc/self/fd", error);
    if (error) return 0;
    // The iterator itself has one of the descriptors open.
    return static_cast<std::size_t>(std::distance(begin, std::filesystem::directory_iterator())) - 1;
}

std::size_t max_descriptors() {
    rlimit limit{};
    return getrlimit(RLIMIT_NOFILE, &limit) == 0 ? limit.rlim_cur : 0;
}

}  // namespace ccdt::server
