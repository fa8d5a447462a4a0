// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string_view>

#include "core/base/result.h"

namespace ccdt::server {

/// Sends the state of this process to the service manager, by the protocol of sd_notify(3). Does nothing unless the
/// service manager has named its socket in the variable NOTIFY_SOCKET, as systemd does for units of the type `notify`.
///
/// @param state  lines such as `READY=1`
/// Error (Internal): the socket does not accept the message. The message names the socket.
Result<void> notify_service_manager(std::string_view state);

}  // namespace ccdt::server
