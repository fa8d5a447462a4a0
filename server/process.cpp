#include "server/process.h"

#include <sys/resource.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>

namespace ccdt::server {

std::size_t resident_bytes() {
    std::size_t all = 0, resident = 0;
    std::ifstream("/proc/self/statm") >> all >> resident;
    return resident * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

std::size_t open_descriptors() {
    std::error_code error;
    const std::filesystem::directory_iterator begin("/proc/self/fd", error);
    if (error) return 0;
    // One of them is the one that reads the list.
    return static_cast<std::size_t>(std::distance(begin, std::filesystem::directory_iterator())) - 1;
}

std::size_t most_descriptors() {
    rlimit limit{};
    return getrlimit(RLIMIT_NOFILE, &limit) == 0 ? limit.rlim_cur : 0;
}

}  // namespace ccdt::server
