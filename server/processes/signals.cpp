// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/processes/signals.h"

namespace ccdt::server {

void ignore_signals(std::span<const int> numbers) {
    for (const int number : numbers) std::signal(number, SIG_IGN);
}

void leave_signals_to_server() {
    ignore_signals(kEndSignals);
    ignore_signals(kSignalsWithoutMeaning);
    std::signal(SIGHUP, SIG_IGN);
}

}  // namespace ccdt::server
