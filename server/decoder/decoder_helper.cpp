#include "server/decoder/decoder_helper.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <ctime>
#include <string_view>
#include <vector>

#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/signalfd.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include "server/decoder/decoder_protocol.h"

namespace ccdt::server {
namespace {

constexpr int kServerGone = 0;
constexpr int kFailed = 1;

constexpr int kQuiet = 5;  ///< milliseconds without orders or deaths, after which nobody seems to wait

/// Ends with its parent, even if that has ended already.
void follow(pid_t parent) {
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent) _exit(kFailed);
}

/// A crashed helper is replaced at once, though not in a tight loop.
void pause_shortly() {
    const timespec pause{0, 10'000'000};
    nanosleep(&pause, nullptr);
}

/// Signals to the group, as from a terminal, are the server's to act on.
void settle_signals() {
    for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGQUIT}) std::signal(number, SIG_IGN);
    std::signal(SIGCHLD, SIG_DFL);  // ignored, children would leave no status
}

/// Leaves the standard streams and one more.
bool close_all_but(int kept) {
    const auto first = static_cast<unsigned>(STDERR_FILENO + 1);
    const auto middle = static_cast<unsigned>(kept);
    const bool closed = middle <= first || close_range(first, middle - 1, 0) == 0;
    return closed && close_range(middle + 1, ~0U, 0) == 0;
}

/// Nothing of the server stays open but `kept`. Sanitizers keep their voice.
bool leave_files(int kept) {
    const int null = open("/dev/null", O_RDWR | O_CLOEXEC);
    if (null < 0) return false;
    for (const int stream : {STDIN_FILENO, STDOUT_FILENO}) dup2(null, stream);
    if (Sandbox::kIsWhole) dup2(null, STDERR_FILENO);
    return close_all_but(kept);
}

class Helper {
public:
    Helper(int orders, const Decoder& decoder, const Sandbox& sandbox)
        : orders_(orders), decoder_(decoder), sandbox_(sandbox), deaths_(watch_children()) {}

    /// Until the server goes.
    void run() {
        while (true) {
            const bool quiet = !wait();
            reap();
            if (spare_.process == 0 && (quiet || children_.empty())) fork_spare();
            for (Child& child : children_) end_if_unwanted(child);
            if (!is_ready(orders_)) continue;
            auto order = receive_order(orders_);
            if (!order) return;
            start(*std::move(order));  // and lets go of its descriptors, which another child must not get
        }
    }

private:
    struct Child {
        pid_t process = 0;
        UniqueFd socket;  ///< to whoever waits for it; a spare's own: to give it an order
    };

    static UniqueFd watch_children() {
        sigset_t signals;
        sigemptyset(&signals);
        sigaddset(&signals, SIGCHLD);
        sigprocmask(SIG_BLOCK, &signals, nullptr);
        return UniqueFd(signalfd(-1, &signals, SFD_CLOEXEC | SFD_NONBLOCK));
    }

    /// @returns  false if nothing happened; only as long as there is no spare
    bool wait() {
        polled_.assign({{orders_, POLLIN, 0}, {deaths_.get(), POLLIN, 0}});
        for (const Child& child : children_) polled_.push_back({child.socket.get(), POLLIN, 0});
        return poll(polled_.data(), polled_.size(), spare_.process == 0 ? kQuiet : -1) != 0;
    }

    bool is_ready(int fd) const {
        const auto found = std::ranges::find(polled_, fd, &pollfd::fd);
        return found != polled_.end() && found->revents != 0;
    }

    void reap() {
        signalfd_siginfo read_away;
        while (read(deaths_.get(), &read_away, sizeof(read_away)) > 0) {
        }
        for (pid_t process = 0; (process = waitpid(-1, nullptr, WNOHANG)) > 0;) {
            const auto child = std::ranges::find(children_, process, &Child::process);
            if (process == spare_.process) spare_ = {};
            if (child == children_.end()) continue;
            report(child->socket, {0, 1});
            children_.erase(child);
        }
    }

    /// Its death is yet to be reaped, so the number is still its own.
    void end_if_unwanted(Child& child) const {
        if (!child.socket || !is_ready(child.socket.get())) return;
        kill(child.process, SIGKILL);
        child.socket.reset();
    }

    static void report(const UniqueFd& outcome, Outcome told) {
        if (outcome) send(outcome.get(), &told, sizeof(told), MSG_NOSIGNAL | MSG_DONTWAIT);
    }

    /// Forks the child for the next order before that comes, and when nobody waits: forking a program with so many
    /// libraries takes longer than all else that is done here.
    void fork_spare() {
        std::array<int, 2> ends{};
        if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends.data()) != 0) return;
        UniqueFd ours(ends[0]);
        const UniqueFd theirs(ends[1]);
        const pid_t self = getpid();
        const pid_t process = fork();
        if (process == 0) {
            follow(self);
            do_order(theirs.get());
        }
        if (process > 0) spare_ = {process, std::move(ours)};
    }

    void start(Order order) {
        if (!order.outcome) return;
        if (spare_.process == 0) fork_spare();
        if (spare_.process == 0) return report(order.outcome, {errno, 1});
        // To a spare that was killed nothing can be sent. The order is lost then, and given again.
        if (send_order(spare_.socket.get(), order)) children_.push_back({spare_.process, std::move(order.outcome)});
        spare_ = {};
    }

    /// In the child.
    [[noreturn]] void do_order(int orders) const {
        sigset_t none;
        sigemptyset(&none);
        sigprocmask(SIG_SETMASK, &none, nullptr);
        if (!close_all_but(orders)) _exit(kFailed);
        auto order = receive_order(orders);
        if (!order || !order->outcome) _exit(kFailed);
        if (order->text.colour != 0) decode(*std::move(order), decoder_.colour);
        decode(*std::move(order), decoder_.grey);
    }

    /// From here on the child has the two mapped files and a socket to whoever waits. That it is done it says itself,
    /// as taking down a process with so many libraries takes milliseconds.
    template <class AnyPicture>
    [[noreturn]] void decode(Order order, const Decoder::To<AnyPicture>& decode_file) const {
        const auto max_pixels = static_cast<std::size_t>(order.text.max_pixels);
        const auto size = static_cast<std::size_t>(order.text.bytes);
        ReplyMemory<AnyPicture> reply(order.reply, max_pixels);
        void* const file = mmap(nullptr, size, PROT_READ, MAP_PRIVATE, order.file.get(), 0);
        if (!reply || (size > 0 && file == MAP_FAILED)) _exit(kFailed);
        const bool moved = dup2(order.outcome.get(), STDOUT_FILENO) == STDOUT_FILENO;
        if (!moved || close_range(STDERR_FILENO + 1, ~0U, 0) != 0) _exit(kFailed);
        if (!sandbox_.enter(order.text.limits, size + reply.size(max_pixels))) _exit(kFailed);
        const std::string_view bytes(size > 0 ? static_cast<const char*>(file) : "", size);
        const auto result =
            decode_file(bytes, max_pixels, [&reply](std::size_t values) { return reply.new_plane(values); });
        const Outcome done;
        if (!reply.write(result) || write(STDOUT_FILENO, &done, sizeof(done)) < 0) _exit(kFailed);
        _exit(0);
    }

    const int orders_;
    const Decoder& decoder_;
    const Sandbox& sandbox_;
    const UniqueFd deaths_;
    std::vector<Child> children_;
    Child spare_;  ///< waits for an order; without a process there is none
    std::vector<pollfd> polled_;
};

/// @returns  whether the server has gone
bool helper_ran_to_its_end(pid_t helper) {
    int status = 0;
    while (waitpid(helper, &status, 0) < 0 && errno == EINTR) {
    }
    return WIFEXITED(status) && WEXITSTATUS(status) == kServerGone;
}

[[noreturn]] void keep_helper(int orders, const Decoder& decoder, const Sandbox& sandbox) {
    const pid_t self = getpid();
    while (true) {
        const pid_t helper = fork();
        if (helper == 0) {
            follow(self);
            Helper(orders, decoder, sandbox).run();
            _exit(kServerGone);
        }
        if (helper > 0 && helper_ran_to_its_end(helper)) _exit(kServerGone);
        pause_shortly();
    }
}

}  // namespace

void run_decoder_helper(UniqueFd orders, const Decoder& decoder) {
    settle_signals();
    if (!leave_files(orders.get())) _exit(kFailed);
    try {
        if (decoder.warm_up) decoder.warm_up();
        const Sandbox sandbox;
        const Hello hello{sandbox.filter_error()};
        if (send(orders.get(), &hello, sizeof(hello), MSG_NOSIGNAL) != static_cast<ssize_t>(sizeof(hello)))
            _exit(kFailed);
        keep_helper(orders.get(), decoder, sandbox);
    } catch (...) {
        _exit(kFailed);
    }
}

}  // namespace ccdt::server
