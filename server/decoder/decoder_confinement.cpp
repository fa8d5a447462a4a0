// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/decoder/decoder_confinement.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <string_view>

#include <grp.h>
#include <linux/capability.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/prctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "server/decoder/decoder_sandbox.h"

namespace ccdt::server {
namespace {

/// Id of the user `nobody` and of its group, on all distributions.
constexpr unsigned kNobody = 65534;

/// Names of the layers, in the order of Layer.
constexpr std::array<std::string_view, Confinement::kLayers> kNames = {
    "no root",       "no capabilities", "network namespace", "mount namespace", "empty root directory",
    "pid namespace", "ipc namespace",   "uts namespace",     "Landlock",        "system call filter"};

struct Namespace {
    Layer layer;
    int flag;
};

constexpr Namespace kNamespaces[] = {
    {Layer::Network, CLONE_NEWNET}, {Layer::Mounts, CLONE_NEWNS},    {Layer::Processes, CLONE_NEWPID},
    {Layer::Ipc, CLONE_NEWIPC},     {Layer::HostName, CLONE_NEWUTS},
};

int error_of(bool done) {
    return done ? 0 : errno;
}

/// Changes to the user `nobody` and its group if the process belongs to root.
void leave_root(Confinement& confinement) {
    if (geteuid() != 0) return;
    const bool dropped = setgroups(0, nullptr) == 0 && setresgid(kNobody, kNobody, kNobody) == 0 &&
                         setresuid(kNobody, kNobody, kNobody) == 0;
    confinement.error(Layer::User) = error_of(dropped);
    if (dropped) confinement.user = kNobody;
}

/// Empties the capability bounding set, which limits the capabilities that a process can gain by executing a program.
/// Ignores failures, because this requires CAP_SETPCAP.
void empty_bounding_set() {
    for (unsigned long capability = 0; prctl(PR_CAPBSET_READ, capability, 0, 0, 0) >= 0; ++capability)
        prctl(PR_CAPBSET_DROP, capability, 0, 0, 0);
}

bool drop_capabilities() {
    prctl(PR_CAP_AMBIENT, PR_CAP_AMBIENT_CLEAR_ALL, 0, 0, 0);
    __user_cap_header_struct header{_LINUX_CAPABILITY_VERSION_3, 0};
    const __user_cap_data_struct none[_LINUX_CAPABILITY_U32S_3] = {};
    return syscall(SYS_capset, &header, none) == 0;
}

/// Replaces the root by an empty file system, and unmounts the previous one. Fails in a chroot, where the root
/// directory is not a mount point.
bool empty_root() {
    constexpr unsigned long kFlags = MS_NOSUID | MS_NODEV | MS_NOEXEC | MS_RDONLY;
    constexpr const char* kPlace = "/proc";  // any existing folder
    return mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0 &&
           mount("none", kPlace, "tmpfs", kFlags, "nr_inodes=1,mode=555") == 0 && chdir(kPlace) == 0 &&
           syscall(SYS_pivot_root, ".", ".") == 0 && umount2(".", MNT_DETACH) == 0 && chdir("/") == 0;
}

}  // namespace

std::string Confinement::describe() const {
    std::string there, missing;
    for (std::size_t i = 0; i < kLayers; ++i) {
        std::string& list = errors[i] == 0 ? there : missing;
        list += list.empty() ? "" : ", ";
        list += kNames[i];
        if (errors[i] != 0) list += std::string(" (") + std::strerror(errors[i]) + ")";
    }
    std::string line = "pictures are decoded by user " + std::to_string(user);
    if (!there.empty()) line += "; in force: " + there;
    if (!missing.empty()) line += "; not in force: " + missing;
    return line;
}

void enter_namespaces(Confinement& confinement) {
    confinement.user = geteuid();
    // An unprivileged process may create these namespaces only inside a new user namespace.
    if (unshare(CLONE_NEWUTS) != 0 && errno == EPERM) {
        leave_root(confinement);
        static_cast<void>(unshare(CLONE_NEWUSER));
    }
    for (const auto& [layer, flag] : kNamespaces) {
        const bool is_spared = layer == Layer::Mounts && !Sandbox::kIsWhole;  // sanitizers have to open files
        confinement.error(layer) = is_spared ? ENOSYS : error_of(unshare(flag) == 0);
    }
}

void drop_privileges(Confinement& confinement) {
    confinement.error(Layer::Root) =
        confinement.has(Layer::Mounts) ? error_of(empty_root()) : confinement.error(Layer::Mounts);
    empty_bounding_set();
    leave_root(confinement);
    confinement.error(Layer::Capabilities) = error_of(drop_capabilities());
}

}  // namespace ccdt::server
