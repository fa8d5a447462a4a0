// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/cli/console.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>

#include <sys/ioctl.h>
#include <unistd.h>

namespace ccdt::server {

std::size_t terminal_width() {
    constexpr unsigned short kDefault = 80, kMin = 40, kMax = 100;
    winsize size{};
    if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return kDefault;
    return std::clamp(size.ws_col, kMin, kMax);
}

int print(const std::string& text) {
    if (std::fputs(text.c_str(), stdout) >= 0 && std::fflush(stdout) == 0) return 0;
    std::fprintf(stderr, "ccdt: cannot write standard output: %s\n", std::strerror(errno));
    return kOutputFailed;
}

}  // namespace ccdt::server
