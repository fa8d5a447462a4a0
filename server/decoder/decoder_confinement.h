// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

namespace ccdt::server {

/// Layers of isolation between decoding processes and the machine. Any of them may be unavailable on a machine or in
/// the container of the server.
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

/// The layers in force, as determined by trying each one.
struct Confinement {
    static constexpr std::size_t kLayers = 10;

    std::uint32_t user = 0;                      ///< user id of the processes
    std::array<std::int32_t, kLayers> errors{};  ///< [layers] 0 if in force, else the errno of the failure

    std::int32_t& error(Layer layer) { return errors[static_cast<std::size_t>(layer)]; }
    bool has(Layer layer) const { return errors[static_cast<std::size_t>(layer)] == 0; }
    bool is_whole() const { return errors == std::array<std::int32_t, kLayers>{}; }

    /// Returns one line for the log.
    std::string describe() const;
};

/// Enters new namespaces and records which are in force. A process that may not create namespaces enters a new user
/// namespace first. If such a process belongs to root, it changes to the user nobody before that.
///
/// The PID namespace applies to children: the first child becomes its init process, and when the init process ends, all
/// processes in the namespace end. Must be called by a single-threaded process.
void enter_namespaces(Confinement& confinement);

/// Replaces the root directory by an empty one, drops all capabilities, and changes from root to the user nobody.
/// Records which of these layers are in force. Must be called after enter_namespaces.
void drop_privileges(Confinement& confinement);

}  // namespace ccdt::server
