// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <csignal>
#include <span>

namespace ccdt::server {

/// Signals that ask a server to end.
inline constexpr std::array kEndSignals{SIGINT, SIGTERM, SIGQUIT};

/// Signals that would end a program by default and that no program of the server uses. SIGPIPE and SIGXFSZ are among
/// them. So a write only fails, and does not end the program, if nobody reads the log any more or if the file would
/// exceed the size limit (ulimit -f).
inline constexpr std::array kSignalsWithoutMeaning{SIGUSR1, SIGUSR2, SIGALRM, SIGVTALRM, SIGPROF,
                                                   SIGIO,   SIGPWR,  SIGPIPE, SIGXFSZ};

void ignore_signals(std::span<const int> numbers);

/// Makes a program that the server has started ignore the signals that a terminal or an operator may send to it. The
/// server itself acts on these signals, and its programs end with it.
void leave_signals_to_server();

}  // namespace ccdt::server
