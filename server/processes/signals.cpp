// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/processes/signals.h"

namespace ccdt::server {

void ignore_signals(std::span<const int> numbers) {
    for (const int number : numbers) std::signal(number, SIG_IGN);
}

sigset_t signals_left_to_server() {
    sigset_t signals;
    sigemptyset(&signals);
    for (const int number : kEndSignals) sigaddset(&signals, number);
    for (const int number : kSignalsWithoutMeaning) sigaddset(&signals, number);
    sigaddset(&signals, SIGHUP);
    return signals;
}

void leave_signals_to_server() {
    const auto signals = signals_left_to_server();
    for (int number = 1; number < NSIG; ++number) {
        if (sigismember(&signals, number) == 1) std::signal(number, SIG_IGN);
    }
    sigprocmask(SIG_UNBLOCK, &signals, nullptr);
}

}  // namespace ccdt::server
