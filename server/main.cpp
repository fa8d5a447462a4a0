#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <csignal>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <memory>
#include <mutex>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <thread>
#include <utility>

#include <unistd.h>

#include "api/image/image_codec.h"
#include "server/access/gate.h"
#include "server/compute/compute_box.h"
#include "server/config/config.h"
#include "server/decoder/decoder_box.h"
#include "server/http/http_server.h"
#include "server/http/sockets.h"
#include "server/jobs/jobs.h"
#include "server/jobs/sqlite_job_store.h"
#include "server/monitoring/log.h"
#include "server/monitoring/metrics.h"
#include "server/processes/child_program.h"
#include "server/processes/process.h"
#include "server/routes/routes.h"
#include "server/work/computation.h"
#include "server/work/worker_pool.h"

namespace ccdt::server {
namespace {

constexpr int kFailed = 1;
constexpr int kWrongUsage = 2;

/// Besides those of connections: the log, libraries, pictures.
constexpr std::size_t kOtherFiles = 256;

/// SIGHUP only if it means something: else it ends the program, as it does when a terminal is closed.
sigset_t awaited_signals(bool reload) {
    sigset_t signals;
    sigemptyset(&signals);
    sigaddset(&signals, SIGINT);
    sigaddset(&signals, SIGTERM);
    if (reload) sigaddset(&signals, SIGHUP);
    return signals;
}

void reload_keys(Gate& gate, const Log& log) {
    if (const auto read = gate.read_keys(); read)
        log.info("the API keys were read again");
    else
        log.error("the API keys stay as they were: " + read.error().message);
}

/// Reads the keys again on SIGHUP, returns on any other signal. From then on another signal ends the program at once.
/// That takes a handler: without one, the first process of a container is not ended by them.
void wait_for_end(const sigset_t& signals, Gate& gate, const Log& log) {
    int number = 0;
    while (sigwait(&signals, &number) == 0 && number == SIGHUP) reload_keys(gate, log);
    std::signal(SIGHUP, SIG_IGN);
    for (const int other : {SIGINT, SIGTERM}) std::signal(other, [](int again) { _exit(128 + again); });
    pthread_sigmask(SIG_UNBLOCK, &signals, nullptr);
}

/// Ends the program in time even if a request does not: first nothing is waited for any more, then it is over.
class Reaper {
public:
    Reaper(std::chrono::milliseconds timeout, Routes& routes, const Log& log)
        : thread_([=, &routes, &log](const std::stop_token& done) {
              constexpr std::chrono::milliseconds kLastWords{1'000};  // for telling those who wait
              const auto last_words = std::min(kLastWords, timeout / 2);
              if (ended_within(timeout - last_words, done)) return;
              log.info("the time to shut down is nearly over: requests that are not done are given up");
              routes.abandon();
              if (ended_within(last_words, done)) return;
              log.error("the time to shut down is over: answers that clients do not take are dropped");
              std::_Exit(EXIT_SUCCESS);
          }) {}

private:
    static bool ended_within(std::chrono::milliseconds time, const std::stop_token& done) {
        std::mutex mutex;
        std::unique_lock lock(mutex);
        std::condition_variable_any never;
        never.wait_for(lock, done, time, [] { return false; });
        return done.stop_requested();
    }

    std::jthread thread_;
};

std::string url(const std::string& address, int port) {
    if (address.starts_with("unix:")) return address;
    const bool has_colon = address.find(':') != std::string::npos;
    return "http://" + (has_colon ? "[" + address + "]" : address) + ":" + std::to_string(port);
}

Result<std::unique_ptr<DecoderBox>> start_box(const Log& log) {
    auto box = DecoderBox::start([](UniqueFd orders) { return spawn_sibling("ccdt-decoder", std::move(orders)); },
                                 [&log](const std::string& message) { log.error(message); });
    if (!box) return box;
    const Confinement& confinement = (*box)->confinement();
    if (confinement.is_whole())
        log.info(confinement.describe());
    else if (confinement.has(Layer::Calls))
        log.warning(confinement.describe());
    else
        log.error(confinement.describe());
    return box;
}

Result<std::unique_ptr<ComputeBox>> start_computing(const Config& config, DecoderBox& box, const Log& log) {
    return ComputeBox::start([](UniqueFd socket) { return spawn_sibling("ccdt-worker", std::move(socket)); },
                             {.limits = config.limits},
                             [&box](const Order& order, const std::stop_token& stop) { box.relay(order, stop); },
                             [&log](const std::string& what) { log.error(what); });
}

/// What is left for requests and what is computed for them: not what the program takes by itself, nor what is on its
/// way to and from clients, nor what is kept of jobs and answers in memory.
Result<std::size_t> memory_to_compute_with(const Config& config) {
    constexpr std::size_t kOthers = std::size_t{160} << 20;  // the decoder's processes, 70 at rest, and threads to come
    constexpr std::size_t kProcess = std::size_t{4} << 20;   // one that computes, at rest
    constexpr std::size_t kLeast = std::size_t{192} << 20;
    const std::size_t kept = config.data_dir.empty() ? config.jobs.bytes : 0;
    const std::size_t processes = (config.workers + 2) * kProcess;  // that for short requests, and what makes them
    const std::size_t taken = resident_bytes() + kOthers + processes + config.capacity.bytes + config.cache + kept;
    if (config.memory >= taken + kLeast) return config.memory - taken;
    const auto mebibytes = [](std::size_t bytes) { return std::to_string(bytes >> 20) + " MiB"; };
    return failure(ErrorCode::Malformed, "a memory of " + mebibytes(config.memory) +
                                             " leaves too little to compute with: " + mebibytes(taken + kLeast) +
                                             " are needed (--memory)");
}

void tell_of_damages(const SqliteJobStore& store, const Log& log) {
    if (const auto count = store.damages(); count > 0)
        log.error("the disk has changed what is stored of jobs: " + std::to_string(count) +
                  " faults were found, and the jobs that cannot be believed have failed");
}

int serve(const Config& config) {
    give_back_freed_memory();

    // Before any thread starts: they inherit the mask, and only this one takes the signals.
    const sigset_t signals = awaited_signals(!config.api_key_file.empty());
    pthread_sigmask(SIG_BLOCK, &signals, nullptr);

    const Log log(config.log_format);
    const auto box = start_box(log);
    if (!box) {
        log.error(box.error().message);
        return kFailed;
    }
    Gate gate(config.api_key_file, config.rate);
    if (const auto read = gate.read_keys(); !read) {
        log.error(read.error().message);
        return kFailed;
    }
    const auto& capacity = config.capacity;
    allow_open_files(capacity.connections + capacity.reserve + capacity.streams + kOtherFiles);
    const auto memory = memory_to_compute_with(config);
    if (!memory) {
        log.error(memory.error().message);
        return kFailed;
    }
    WorkerPool pool(config.workers, config.queue, *memory / 4 * 3);  // routes take the rest, for requests
    const auto store = SqliteJobStore::open(config.data_dir);
    if (!store) {
        log.error(store.error().message);
        return kFailed;
    }
    tell_of_damages(**store, log);
    const auto computing = start_computing(config, **box, log);
    if (!computing) {
        log.error(computing.error().message);
        return kFailed;
    }
    const Compute compute = [box = computing->get()](const auto& question, const auto& manner, const auto& control,
                                                     auto& timings) {
        return box->compute(question, manner, control, timings);
    };
    Metrics metrics(CCDT_VERSION);
    Jobs jobs(config.jobs, **store, !config.data_dir.empty(), pool, compute, [&](const JobEnd& end) {
        metrics.add(end);
        log.job(end);
    });
    const auto lacking = [&]() -> std::string {
        if (!(*box)->is_ready()) return "the decoder of pictures is being started again";
        return (*computing)->is_ready() ? "" : "what makes the processes that compute is being started again";
    };
    Routes routes(config, {gate, pool, compute, jobs, metrics, lacking});
    const auto listening = HttpServer::listen(
        config.bind, config.port, config.patience, config.capacity,
        [&](const auto& request, const auto& received, auto& connection) {
            return routes.answer(request, received, connection);
        },
        [&](const Exchange& exchange) {
            metrics.add(exchange);
            log.exchange(exchange);
        });
    if (!listening) {
        log.error(listening.error().message);
        return kFailed;
    }
    HttpServer& server = **listening;
    metrics.watch([&] {
        return Metrics::Watched{.connections = server.connections(),
                                .memory_budget = *memory,
                                .memory_reserved = pool.memory().taken() + routes.waiting_memory().taken(),
                                .decoder_restarts = (*box)->restarts(),
                                .computing = (*computing)->counts(),
                                .jobs = jobs.counts(),
                                .job_bytes = jobs.stored_bytes(),
                                .job_capacity = config.jobs.bytes,
                                .job_damages = (*store)->damages(),
                                .cache = routes.cache().load()};
    });
    if (const auto started = jobs.start(); !started) {
        log.error(started.error().message);
        return kFailed;
    }
    log.info("listening on " + url(config.bind, server.port()));

    bool served = false;
    std::jthread acceptor([&] {
        served = server.serve();
        if (served) return;
        log.error("accepting connections failed");
        kill(getpid(), SIGTERM);
    });
    wait_for_end(signals, gate, log);
    const Reaper reaper(config.drain_timeout, routes, log);
    routes.drain();
    server.drain();
    jobs.drain();
    log.info("shutting down: no new requests, those accepted are answered");
    acceptor.join();
    pool.drain();
    log.info("stopped");
    return served ? EXIT_SUCCESS : kFailed;
}

int run(std::span<const char* const> arguments) {
    const auto command = parse_command_line(arguments, [](const char* name) { return std::getenv(name); });
    if (!command) {
        std::fprintf(stderr, "ccdt-server: %s\nTry --help.\n", command.error().message.c_str());
        return kWrongUsage;
    }
    switch (command->action) {
        case CommandLine::Action::Help:
            std::fputs(usage().c_str(), stdout);
            return EXIT_SUCCESS;
        case CommandLine::Action::Version:
            std::puts("ccdt-server " CCDT_VERSION);
            return EXIT_SUCCESS;
        case CommandLine::Action::Serve:
            break;
    }
    return serve(command->config);
}

}  // namespace
}  // namespace ccdt::server

int main(int argc, char** argv) {
    try {
        return ccdt::server::run(std::span(argv, static_cast<std::size_t>(argc)).subspan(1));
    } catch (const std::exception& exception) {
        std::fprintf(stderr, "ccdt-server: %s\n", exception.what());
        return 1;
    }
}
