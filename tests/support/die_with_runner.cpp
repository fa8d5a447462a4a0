// SPDX-License-Identifier: GPL-3.0-or-later
#include <csignal>

#include <sys/prctl.h>

namespace ccdt {
namespace {

/// Makes the system kill the test program when its parent process ends. Programs that the test started detect
/// this and end as well, like the child programs of a server.
[[maybe_unused]] const bool kDiesWithRunner = prctl(PR_SET_PDEATHSIG, SIGKILL) == 0;

}  // namespace
}  // namespace ccdt
