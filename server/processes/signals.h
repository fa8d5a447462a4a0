#pragma once

namespace ccdt::server {

/// Ignores the signals that a terminal or a service manager sends to all processes: they are the server's to act on,
/// and what it has started ends with it.
void leave_signals_to_server();

}  // namespace ccdt::server
