// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

namespace ccdt::server {

/// Layers of isolation between decoding processes and the machine. Each layer may be unavailable, depending on the
/// kernel and the container.
enum class Layer : std::uint8_t {
    User,          ///< the process does not belong to root
    Capabilities,  ///< the process has no capabilities
    Network,       ///< a new, empty network namespace
    Mounts,        ///< a new mount namespace
    Root,          ///< an empty root directory; requires Mounts, and a server that does not run in a chroot
    Processes,     ///< a new PID namespace
    Ipc,           ///< a new IPC namespace
    HostName,      ///< a new UTS namespace
    Landlock,      ///< denies access to files and ports, and signals to processes outside
    Calls,         ///< the kernel filters system calls
};

/// The layers that are in force, determined by trying each of them.
struct Confinement {
    static constexpr std::size_t kLayers = 10;

    std::uint32_t user = 0;                      ///< user id of the processes
    std::array<std::int32_t, kLayers> errors{};  ///< for each layer: 0 if in force, otherwise errno

    std::int32_t& error(Layer layer) { return errors[static_cast<std::size_t>(layer)]; }
    bool has(Layer layer) const { return errors[static_cast<std::size_t>(layer)] == 0; }
    bool is_whole() const { return errors == std::array<std::int32_t, kLayers>{}; }

    /// Returns one line for the log.
    std::string describe() const;
};

/// Enters new namespaces and records which are in force. If the process may not create them, it first enters a new user
/// namespace. In that case, a process of root changes to the user `nobody` before it enters the user namespace.
///
/// The PID namespace applies to children of the caller. The first child becomes the init process; when it ends, all
/// processes in the namespace end. Must be called by a single-threaded process.
void enter_namespaces(Confinement& confinement);

/// Replaces the root directory by an empty one, drops all capabilities, and changes from root to the user `nobody`.
/// Records which of these layers are in force. Must be called after enter_namespaces.
void drop_privileges(Confinement& confinement);

}  // namespace ccdt::server
