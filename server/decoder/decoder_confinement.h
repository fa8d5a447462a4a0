// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>

namespace ccdt::server {

/// Layers that keep processes that decode from the machine. A machine, or a container around the server, may lack any.
enum class Layer : std::uint8_t {
    User,          ///< it is not root's
    Capabilities,  ///< it has none
    Network,       ///< a namespace of its own, which is empty, as those of processes, ipc and host name
    Mounts,        ///< a namespace of its own
    Root,          ///< an empty root directory; needs Mounts, and a server outside of chroot
    Processes,
    Ipc,
    HostName,
    Landlock,  ///< no access to files, ports, signals to others
    Calls,     ///< the kernel filters its system calls
};

/// The layers that are in force, as found by trying.
struct Confinement {
    static constexpr std::size_t kLayers = 10;

    std::uint32_t user = 0;                      ///< whose the processes are
    std::array<std::int32_t, kLayers> errors{};  ///< errno for why a layer is not in force; 0: it is

    std::int32_t& error(Layer layer) { return errors[static_cast<std::size_t>(layer)]; }
    bool has(Layer layer) const { return errors[static_cast<std::size_t>(layer)] == 0; }
    bool is_whole() const { return errors == std::array<std::int32_t, kLayers>{}; }

    /// One line for people.
    std::string describe() const;
};

/// Enters the namespaces, where need be through one of users, for which root becomes nobody first. That of processes is
/// for children: the first becomes its init, with whose end all in it end.
///
/// To be called by a process of one thread. Tells which are in force.
void enter_namespaces(Confinement& confinement);

/// Leaves the calling process no file, no capability, and no user's rights but those it was started with; of root's
/// none. To be called after enter_namespaces. Tells what is in force.
void give_up_rights(Confinement& confinement);

}  // namespace ccdt::server
