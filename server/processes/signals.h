// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <csignal>
#include <span>

namespace ccdt::server {

/// Signals that ask a server to end.
inline constexpr std::array kEndSignals{SIGINT, SIGTERM, SIGQUIT};

/// Signals that would end a program by default and that no program of the server uses. Because SIGPIPE and SIGXFSZ are
/// ignored, writing to a closed log or beyond the file size limit (ulimit -f) fails without ending the program.
inline constexpr std::array kSignalsWithoutMeaning{SIGUSR1, SIGUSR2, SIGALRM, SIGVTALRM, SIGPROF,
                                                   SIGIO,   SIGPWR,  SIGPIPE, SIGXFSZ};

void ignore_signals(std::span<const int> numbers);

/// Returns the signals from a terminal or an operator on which only the server acts: kEndSignals, SIGHUP and
/// kSignalsWithoutMeaning. The server starts its programs with these signals blocked; the programs end with the server.
sigset_t signals_left_to_server();

/// Makes a program that the server has started ignore signals_left_to_server(), and unblocks them.
void leave_signals_to_server();

}  // namespace ccdt::server
