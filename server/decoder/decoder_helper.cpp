// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/decoder/decoder_helper.h"

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <ctime>
#include <filesystem>
#include <iterator>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "server/decoder/decoder_confinement.h"
#include "server/decoder/decoder_protocol.h"
#include "server/processes/child_program.h"
#include "server/processes/forked_children.h"
#include "server/processes/messages.h"
#include "server/processes/process.h"
#include "server/processes/signals.h"

namespace ccdt::server {
namespace {

constexpr int kServerGone = 0;
constexpr int kFailed = 1;

/// Makes the kernel end the calling process when `parent` ends. Exits at once if `parent` has already ended.
void follow(pid_t parent) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent) _exit(kFailed);
}

/// Descriptors that stay open in the helper and its children, besides the standard streams: the socket for orders, and
/// /proc, which cannot be opened once the root directory is empty.
constexpr int kOrders = STDERR_FILENO + 1;
constexpr int kProc = kOrders + 1;

/// Moves the socket to kOrders. Closes all files except kOrders, kProc and the standard streams.
bool leave_files(int orders) {
    return dup2(orders, kOrders) == kOrders && close_range(kProc + 1, ~0U, 0) == 0;
}

/// Closes inherited files, and redirects the standard streams to /dev/null. With sanitizers, keeps standard error.
bool leave_files_of_server(int orders) {
    if (dup2(orders, kOrders) != kOrders) return false;
    const int null = open("/dev/null", O_RDWR | O_CLOEXEC);
    const int proc = open("/proc", O_PATH | O_DIRECTORY | O_CLOEXEC);
    for (const int stream : {STDIN_FILENO, STDOUT_FILENO}) dup2(null, stream);
    if (Sandbox::kIsWhole) dup2(null, STDERR_FILENO);
    return null >= 0 && dup2(proc, kProc) == kProc && leave_files(kOrders);
}

void report(const UniqueFd& outcome, const Outcome& reported) {
    send(outcome.get(), &reported, sizeof(reported), MSG_NOSIGNAL | MSG_DONTWAIT);
}

void report_end(const UniqueFd& outcome, int status, std::chrono::microseconds used) {
    const bool too_slow = WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU;
    report(outcome, {.ended = 1,
                     .too_slow = too_slow ? 1 : 0,
                     .killed = is_killed_from_outside(status) ? 1 : 0,
                     .used_us = used.count()});
}

class Helper {
public:
    Helper(const Decoder& decoder, const Sandbox& sandbox)
        : decoder_(decoder), sandbox_(sandbox), children_(UniqueFd(kOrders), report_end) {}

    /// Carries out orders until the server has ended.
    void run() {
        while (true) {
            Order order;  // destroyed before the next order arrives, so that the next child does not inherit its files
            auto files = children_.wait_for_order(writable_bytes_of(order.text), [this] { fork_spare(); });
            if (!files) return;
            order.take(*std::move(files));
            if (order.outcome) start(std::move(order));
        }
    }

private:
    /// A child that waits for an order.
    struct Spare {
        pid_t process = 0;  ///< 0: none
        UniqueFd socket;    ///< socket for the child's order
    };

    /// Forks a spare child for the next order, unless there is one. Called before the order arrives, because forking a
    /// program with many libraries takes longer than all other steps in this class.
    void fork_spare() {
        if (spare_.process != 0) return;
        auto sockets = make_sockets(SOCK_SEQPACKET);
        if (!sockets) return;
        const pid_t self = getpid();
        const pid_t process = children_.fork();
        if (process == 0) {
            follow(self);
            do_order(sockets->theirs.get());
        }
        if (process > 0) spare_ = {process, std::move(sockets->ours)};
    }

    void start(Order order) {
        fork_spare();
        if (spare_.process == 0) return report(order.outcome, {.fork_error = errno, .ended = 1});
        // If the spare child was killed, the order is lost, and DecoderClient repeats it.
        if (send_order(spare_.socket.get(), order)) children_.add(spare_.process, std::move(order.outcome));
        spare_ = {};
    }

    /// Waits for an order and executes it. Called in the child.
    [[noreturn]] void do_order(int orders) const {
        prctl(PR_SET_NAME, "decoder");
        if (!leave_files(orders)) _exit(kFailed);
        auto order = receive_order(kOrders);
        if (!order || !order->outcome) _exit(kFailed);
        report(order->outcome, {.begun = 1});
        Sandbox::volunteer_for_out_of_memory(kProc);
        switch (order->text.product) {
            case Order::Product::Grey:
                decode(*std::move(order), decoder_.grey);
            case Order::Product::Colour:
                decode(*std::move(order), decoder_.colour);
            case Order::Product::Map:
                decode_map(*std::move(order));
            case Order::Product::Surface:
                decode_surface(*std::move(order));
        }
        _exit(kFailed);
    }

    /// Reports errno as the reason why no file can be decoded, and ends the process. Called in the child.
    [[noreturn]] static void fail(const UniqueFd& outcome) {
        report(outcome, {.fork_error = errno, .ended = 1});
        _exit(kFailed);
    }

    /// Reports the share of the file that is decoded, unless it is nearly the same as before. Called in the child.
    static void report_progress(double decoded) {
        constexpr double kStep = 1.0 / (Outcome::kMaxBegun - 2);
        static double reported = 0;
        if (decoded < reported + kStep) return;
        reported = decoded;
        const Outcome step{.begun = 1, .decoded = decoded};
        if (write(STDOUT_FILENO, &step, sizeof(step)) < 0) _exit(kFailed);
    }

    template <class AnyPicture>
    [[noreturn]] void decode(Order order, const Decoder::To<AnyPicture>& decode_file) const {
        const auto max_pixels = static_cast<std::size_t>(order.text.max_size);
        ReplyMemory<AnyPicture> reply(order.reply, max_pixels);
        carry_out(std::move(order), reply, [&](std::string_view bytes, const Order::Text& text) {
            api::Reading reading(max_pixels, text.reduce);
            reading.is_stack = text.is_stack != 0;
            reading.ground = text.ground;
            reading.progress = report_progress;
            const auto result =
                decode_file(bytes, reading, [&reply](std::size_t values) { return reply.new_plane(values); });
            return reply.write(result);
        });
    }

    [[noreturn]] void decode_map(Order order) const {
        const auto max_bytes = static_cast<std::size_t>(order.text.max_size);
        ReplyText reply(order.reply, max_bytes);
        carry_out(std::move(order), reply, [&](std::string_view bytes, const Order::Text& text) {
            if (!decoder_.map) return false;
            reply.write(decoder_.map(bytes, {text.object.data(), max_bytes},
                                     [&reply](std::string_view piece) { return reply.append(piece); }));
            return true;
        });
    }

    [[noreturn]] void decode_surface(Order order) const {
        ReplySurface reply(order.reply, static_cast<std::size_t>(order.text.max_size));
        carry_out(std::move(order), reply, [&](std::string_view bytes, const Order::Text& text) {
            return decoder_.surface && reply.write(decoder_.surface(bytes, text.surface));
        });
    }

    /// Decodes a file and ends the process. While it decodes, the child has only the two mapped files and a socket. The
    /// child reports its outcome before it ends, because ending a process with many libraries takes milliseconds.
    /// @param decode_bytes  decodes the file and writes the reply; returns false on failure
    template <class Reply, class DecodeBytes>
    [[noreturn]] void carry_out(Order order, const Reply& reply, const DecodeBytes& decode_bytes) const {
        const auto size = static_cast<std::size_t>(order.text.bytes);
        void* const file = mmap(nullptr, size, PROT_READ, MAP_PRIVATE, order.file.get(), 0);
        if (!reply || (size > 0 && file == MAP_FAILED)) fail(order.outcome);
        const bool moved = dup2(order.outcome.get(), STDOUT_FILENO) == STDOUT_FILENO;
        if (!moved || close_range(STDERR_FILENO + 1, ~0U, 0) != 0) _exit(kFailed);
        const std::size_t mapped = size + Reply::size(static_cast<std::size_t>(order.text.max_size));
        if (!sandbox_.enter(order.text.limits, mapped)) fail(UniqueFd(STDOUT_FILENO));
        const std::string_view bytes(size > 0 ? static_cast<const char*>(file) : "", size);
        if (!decode_bytes(bytes, order.text)) _exit(kFailed);
        const Outcome done{.used_us = processor_time().count()};
        if (write(STDOUT_FILENO, &done, sizeof(done)) < 0) _exit(kFailed);
        _exit(0);
    }

    const Decoder& decoder_;
    const Sandbox& sandbox_;
    ForkedChildren children_;
    Spare spare_;
};

/// Waits for all children, and ends with the exit status of the helper. Apart from the starter, the helper is the first
/// child to end. Its own children become children of this process only afterwards, and only without a PID namespace. If
/// a signal kills the starter, there may be no helper, and this process ends like the starter.
/// @param starter   child that forked the helper
/// @param adoption  is closed when the starter has ended, so that the helper is a child of this process
[[noreturn]] void end_like_helper(pid_t starter, UniqueFd adoption) {
    prctl(PR_SET_NAME, "decoder-keeper");
    std::optional<int> end;
    while (true) {
        int status = 0;
        const pid_t child = wait(&status);
        if (child < 0 && errno != EINTR) break;
        if (child == starter) adoption.reset();
        if (child > 0 && (child != starter || WIFSIGNALED(status)) && !end) end = status;
    }
    if (end && WIFSIGNALED(*end)) {
        std::signal(WTERMSIG(*end), SIG_DFL);
        std::raise(WTERMSIG(*end));
    }
    _exit(end && WIFEXITED(*end) ? WEXITSTATUS(*end) : kFailed);
}

/// Forks the helper, which has one thread and is in new namespaces. Returns only in the helper. The calling process
/// waits for the end of the helper, and then exits.
///
/// The calling process may have several threads, which libraries start early, and such a process cannot enter a user
/// namespace. Therefore a child enters the namespaces. The helper is a child of that child, because a PID namespace
/// applies only to children of the process that enters it.
/// @returns  a socket whose other end is closed when the calling process has become the parent of the helper
UniqueFd continue_in_namespaces(Confinement& confinement) {
    prctl(PR_SET_CHILD_SUBREAPER, 1);
    auto adoption = make_sockets(SOCK_SEQPACKET);
    if (!adoption) _exit(kFailed);
    const pid_t child = fork();
    if (child == 0) {
        adoption->ours.reset();
        enter_namespaces(confinement);
        const pid_t helper = fork();
        if (helper == 0) return std::move(adoption->theirs);
        _exit(helper > 0 ? 0 : kFailed);
    }
    dup2(adoption->ours.get(), kOrders);
    close_range(kOrders + 1, ~0U, 0);
    end_like_helper(child, UniqueFd(kOrders));
}

/// Counts the threads of this process; 0 on failure.
std::ptrdiff_t count_threads() {
    std::error_code error;
    const std::filesystem::directory_iterator threads("/proc/self/task", error);
    return error ? 0 : std::distance(begin(threads), end(threads));
}

void pause_shortly() {
    const timespec pause{0, 10'000'000};
    nanosleep(&pause, nullptr);
}

/// Initialises the decoding libraries, and waits, for up to 5 s, until the threads that they start and detach have
/// ended. If such a thread held a lock during a fork, the lock would stay held in all children.
void warm_up(const Decoder& decoder) {
    if (!decoder.warm_up) return;
    constexpr int kMaxPauses = 500;
    const auto before = count_threads();
    decoder.warm_up();
    for (int pauses = 0; count_threads() > before && pauses < kMaxPauses; ++pauses) pause_shortly();
}

/// Forks the decoder's helper, a process in new namespaces. The helper executes orders until the server has ended, and
/// then returns. The calling process does not return: it waits for the end of the helper, and exits.
/// @returns  false if the helper could not report that it is ready
bool be_helper(const Decoder& decoder) {
    warm_up(decoder);
    Confinement confinement;
    UniqueFd adoption = continue_in_namespaces(confinement);
    prctl(PR_SET_NAME, "decoder-helper");
    const Sandbox sandbox;
    confinement.error(Layer::Landlock) = sandbox.landlock_error();
    confinement.error(Layer::Calls) = sandbox.filter_error();
    drop_privileges(confinement);
    // Makes the kernel end the helper when the keeper ends. Otherwise, a helper that hangs would keep orders from being
    // repeated. Neither holds for an earlier parent, nor across a change of the user.
    receive_message(adoption.get(), {});
    adoption.reset();
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    const Hello hello{confinement};
    if (send(kOrders, &hello, sizeof(hello), MSG_NOSIGNAL) != static_cast<ssize_t>(sizeof(hello))) return false;
    Helper(decoder, sandbox).run();
    return true;
}

}  // namespace

void run_decoder_helper(UniqueFd orders, const Decoder& decoder) {
    leave_signals_to_server();
    std::signal(SIGCHLD, SIG_DFL);  // if SIGCHLD were ignored, wait() would return no status
    try {
        if (leave_files_of_server(orders.release()) && be_helper(decoder)) _exit(kServerGone);
    } catch (...) {  // ends the process below
    }
    _exit(kFailed);
}

}  // namespace ccdt::server
