// SPDX-License-Identifier: GPL-3.0-or-later
#include <csignal>

#include <sys/prctl.h>

namespace ccdt {
namespace {

/// Has the system kill the test program when the process that started it ends. Programs that it has started notice that
/// it is gone, as those of a server do.
[[maybe_unused]] const bool kDiesWithRunner = prctl(PR_SET_PDEATHSIG, SIGKILL) == 0;

}  // namespace
}  // namespace ccdt
