// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/decoder/decoder_sandbox.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstdio>
#include <span>
#include <utility>
#include <vector>

#include <fcntl.h>
#include <linux/filter.h>
#include <linux/landlock.h>
#include <linux/seccomp.h>
#include <seccomp.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include "server/processes/unique_fd.h"

namespace ccdt::server {
namespace {

/// Allowed system calls: for allocating, computing and exiting. All others fail with EPERM, which libraries tolerate,
/// for example when they look for an optional file.
constexpr auto kAllowed = std::to_array<int>({
    SCMP_SYS(read),
    SCMP_SYS(brk),
    SCMP_SYS(munmap),
    SCMP_SYS(mremap),
    SCMP_SYS(madvise),
    SCMP_SYS(futex),
    SCMP_SYS(clock_gettime),
    SCMP_SYS(gettimeofday),
    SCMP_SYS(getrandom),
    SCMP_SYS(sched_yield),
    SCMP_SYS(rt_sigreturn),
    SCMP_SYS(rt_sigprocmask),
    SCMP_SYS(exit),
    SCMP_SYS(exit_group),
    SCMP_SYS(restart_syscall),
});

/// System calls for Channels::Sockets. None of them makes a socket or connects one.
constexpr auto kAllowedWithSockets = std::to_array<int>({
    SCMP_SYS(recvfrom),
    SCMP_SYS(sendto),
    SCMP_SYS(sendmsg),
    SCMP_SYS(poll),
    SCMP_SYS(setsockopt),
    SCMP_SYS(getsockopt),
    SCMP_SYS(getsockname),
    SCMP_SYS(getpeername),
    SCMP_SYS(shutdown),
    SCMP_SYS(fcntl),
    SCMP_SYS(close),
});
constexpr rlim_t kMaxSockets = 16;

/// System calls that map memory, which are allowed only for memory that is not executable.
constexpr auto kAllowedWithoutExec = std::to_array<int>({SCMP_SYS(mmap), SCMP_SYS(mprotect)});

Sandbox::Memory own_memory() {
    Sandbox::Memory memory;
    std::FILE* const file = std::fopen("/proc/self/statm", "re");
    if (file == nullptr) return memory;
    const bool read = std::fscanf(file, "%zu %*u %*u %*u %*u %zu", &memory.space, &memory.data) == 2;
    std::fclose(file);
    if (!read) return {};
    const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
    return {memory.space * page, memory.data * page};
}

bool add_rules(scmp_filter_ctx context, Sandbox::Channels channels) {
    bool added = true;
    const auto allow = [&](std::span<const int> calls) {
        for (const int call : calls) added &= seccomp_rule_add(context, SCMP_ACT_ALLOW, call, 0) == 0;
    };
    allow(kAllowed);
    if (channels == Sandbox::Channels::Sockets) {
        allow(kAllowedWithSockets);
        // libcurl 7.88 calls connect() even for a connected socket, and then waits until it can write to the socket.
        added &= seccomp_rule_add(context, SCMP_ACT_ERRNO(EINPROGRESS), SCMP_SYS(connect), 0) == 0;
    }
    for (const int call : kAllowedWithoutExec) {
        const scmp_arg_cmp without_exec{2, SCMP_CMP_MASKED_EQ, PROT_EXEC, 0};
        added &= seccomp_rule_add_array(context, SCMP_ACT_ALLOW, call, 1, &without_exec) == 0;
    }
    const scmp_arg_cmp to_output{0, SCMP_CMP_EQ, STDOUT_FILENO, 0};
    return added && seccomp_rule_add_array(context, SCMP_ACT_ALLOW, SCMP_SYS(write), 1, &to_output) == 0;
}

/// Compiles the filter to BPF, the kernel's format, once for all children.
/// @returns  empty on failure
std::vector<sock_filter> compile(scmp_filter_ctx context, Sandbox::Channels channels) {
    const UniqueFd file(memfd_create("filter", MFD_CLOEXEC));
    if (!add_rules(context, channels) || seccomp_export_bpf(context, file.get()) != 0) return {};
    std::vector<sock_filter> program(static_cast<std::size_t>(lseek(file.get(), 0, SEEK_END)) / sizeof(sock_filter));
    const auto bytes = std::as_writable_bytes(std::span(program));
    if (pread(file.get(), bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) return {};
    return program;
}

/// Lowers a resource limit, unless it is lower already.
/// @param margin  difference of the hard and the soft limit
bool limit(__rlimit_resource resource, rlim_t soft, rlim_t margin = 0) {
    rlimit now{};
    if (getrlimit(resource, &now) != 0) return false;
    const rlimit both{std::min(soft, now.rlim_max), std::min(soft + margin, now.rlim_max)};
    return setrlimit(resource, &both) == 0;
}

/// Whether the hard limit, which cannot be raised, is at least `least`. Otherwise, sets errno.
bool leaves(__rlimit_resource resource, rlim_t least) {
    rlimit now{};
    if (getrlimit(resource, &now) != 0) return false;
    if (now.rlim_max >= least) return true;
    errno = ENOMEM;
    return false;
}

/// Rights that Landlock denies, as bit sets, in the layout of the kernel's landlock_ruleset_attr. The rights depend on
/// the version of Landlock.
struct LandlockRules {
    std::uint64_t files = 0;
    std::uint64_t ports = 0;
    std::uint64_t others = 0;  ///< signals and abstract sockets
};

LandlockRules rules_of(long version) {
    constexpr auto bits = [](int count) { return (std::uint64_t{1} << count) - 1; };
    // Number of file rights by version; 16 from version 5 on.
    constexpr auto kFiles = std::to_array<int>({0, 13, 14, 15, 15, 16});
    const auto known = static_cast<std::size_t>(std::clamp(version, 0L, static_cast<long>(kFiles.size()) - 1));
    return {bits(kFiles[known]), version >= 4 ? bits(2) : 0, version >= 6 ? bits(2) : 0};
}

long landlock_version() {
    return syscall(SYS_landlock_create_ruleset, nullptr, 0, LANDLOCK_CREATE_RULESET_VERSION);
}

/// Applies Landlock to the calling process. Requires PR_SET_NO_NEW_PRIVS.
bool enter_landlock(const LandlockRules& rules) {
    const UniqueFd ruleset(static_cast<int>(syscall(SYS_landlock_create_ruleset, &rules, sizeof(rules), 0)));
    return ruleset && syscall(SYS_landlock_restrict_self, ruleset.get(), 0) == 0;
}

/// Tries a step in a child process.
/// @returns  0 if the step succeeded, otherwise its errno
template <class Step>
int try_in_child(const Step& step) {
    if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return errno;
    if (!Sandbox::kIsWhole) return ENOSYS;
    const pid_t child = fork();
    if (child < 0) return errno;
    if (child == 0) _exit(step() ? 0 : errno);
    int status = 0;
    if (waitpid(child, &status, 0) != child) return errno;
    return WIFEXITED(status) ? WEXITSTATUS(status) : ENOSYS;
}

}  // namespace

struct Sandbox::Filter {
    std::vector<sock_filter> program;  ///< empty if it could not be compiled

    static std::unique_ptr<const Filter> create(Channels channels) {
        Filter filter;
        if (const scmp_filter_ctx context = seccomp_init(SCMP_ACT_ERRNO(EPERM))) {
            filter.program = compile(context, channels);
            seccomp_release(context);
        }
        return std::make_unique<const Filter>(std::move(filter));
    }
};

Sandbox::Sandbox(Channels channels)
    : channels_(channels),
      own_(own_memory()),
      filter_(Filter::create(channels)),
      filter_error_(try_in_child([this] { return filter_calls(); })),
      landlock_error_(try_in_child([] { return enter_landlock(rules_of(landlock_version())); })) {}

Sandbox::~Sandbox() = default;

void Sandbox::volunteer_for_out_of_memory(int proc) {
    prctl(PR_SET_DUMPABLE, 1, 0, 0, 0);  // otherwise the file belongs to root
    const UniqueFd file(openat(proc, "self/oom_score_adj", O_WRONLY | O_CLOEXEC));
    if (file) static_cast<void>(!write(file.get(), "1000", 4));
}

bool Sandbox::enter(const DecoderLimits& limits, std::size_t mapped) const {
    // Prevents core dumps, and access by debuggers of the same user.
    if (prctl(PR_SET_DUMPABLE, 0, 0, 0, 0) != 0) return false;
    if (landlock_error_ == 0 && !enter_landlock(rules_of(landlock_version()))) return false;
    return limit_resources(limits, mapped) && (filter_error_ != 0 || filter_calls());
}

bool Sandbox::limit_resources(const DecoderLimits& limits, std::size_t mapped) const {
    // The allocator reserves much address space for threads, of which it uses little.
    constexpr std::size_t kReserved = std::size_t{512} << 20;
    const rlim_t data = own_.data + limits.memory;
    const rlim_t space = own_.space + mapped + limits.memory;
    const bool shut = !kIsWhole || (leaves(RLIMIT_DATA, data) && leaves(RLIMIT_AS, space) && limit(RLIMIT_DATA, data) &&
                                    limit(RLIMIT_AS, space + kReserved) &&
                                    limit(RLIMIT_NOFILE, channels_ == Channels::Sockets ? kMaxSockets : 0));
    // At the soft limit, SIGXCPU tells the helper why the child ended. At the hard limit, the kernel sends SIGKILL.
    constexpr rlim_t kMargin = 1;
    return shut && limit(RLIMIT_CPU, static_cast<rlim_t>(limits.time.count()), kMargin) && limit(RLIMIT_FSIZE, 0) &&
           limit(RLIMIT_CORE, 0) && limit(RLIMIT_NPROC, 0);
}

bool Sandbox::filter_calls() const {
    if (filter_->program.empty()) {
        errno = ENOSYS;
        return false;
    }
    // The kernel only reads the program, although the member is not const.
    auto* const begin = const_cast<sock_filter*>(filter_->program.data());
    const sock_fprog program{static_cast<unsigned short>(filter_->program.size()), begin};
    return prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &program) == 0;
}

}  // namespace ccdt::server
