// SPDX-License-Identifier: GPL-3.0-or-later
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <functional>
#include <span>
#include <stop_token>
#include <string>
#include <thread>

#include <unistd.h>

#include "server/config/config.h"
#include "server/monitoring/log.h"
#include "server/processes/process.h"
#include "server/processes/service_manager.h"
#include "server/service/check.h"
#include "server/service/health.h"
#include "server/service/service.h"
#include "server/service/shutdown.h"

namespace ccdt::server {
namespace {

constexpr int kFailed = 1;
constexpr int kWrongUsage = 2;

/// Returns all environment variables, as `NAME=value`.
std::span<const char* const> environment() {
    std::size_t count = 0;
    while (environ[count] != nullptr) ++count;
    return {environ, count};
}

/// Reloads the file of settings and the key files.
/// @param running    command line with which the server runs
/// @param arguments  arguments of that command line
void reload(Service& service, const CommandLine& running, std::span<const char* const> arguments, const Log& log) {
    const Config& config = running.config;
    if (config.api_key_file.empty() && config.signing.file.empty() && config.file.empty() &&
        config.presets_file.empty() && config.webhook_key_file.empty())
        return log.info("SIGHUP is ignored: there is no file to reload");
    const auto fresh = parse_command_line(arguments, environment());
    const auto done = fresh ? service.reload(fresh->config.live) : tl::unexpected(fresh.error());
    if (!done) return log.error("settings and keys stay as they were: " + done.error().message);
    log.info("settings and keys were reloaded");
    const std::string changes = changes_for_restart(running.values, fresh->values);
    if (!changes.empty()) log.warning("these settings have changed, but need a restart: " + changes);
}

/// Tells the service manager the state of the server, and logs a failure, after which the manager may stop the server.
void notify(const std::string& state, const Log& log) {
    if (const auto notified = notify_service_manager(state); !notified) log.error(notified.error().message);
}

/// Returns the message that announces the end of the server. It asks the service manager to wait for one second longer
/// than the drain time-out.
std::string stopping(const Config& config) {
    const std::chrono::microseconds wait = config.drain_timeout + std::chrono::seconds(1);
    return "STOPPING=1\nEXTEND_TIMEOUT_USEC=" + std::to_string(wait.count());
}

/// Ends the server like SIGTERM from outside.
void end_serving() {
    kill(getpid(), SIGTERM);
}

/// Serves until a signal arrives, accepting connections fails, or a program of the server does not start.
/// @returns  false after a failure
/// @param reload  called for each SIGHUP
bool serve_until_signal(Service& service, const ServerSignals& signals, const Config& config,
                        const std::function<void()>& reload, const Log& log) {
    ShutdownDeadline deadline(
        config.drain_timeout, [&] { service.abandon(); }, log);
    bool started = true;
    std::jthread starter([&](const std::stop_token& stop) {
        const auto ready = service.wait_until_ready(stop);
        if (ready) notify("READY=1\nSTATUS=listening on " + service.address(), log);
        if (ready || stop.stop_requested()) return;
        started = false;
        log.error(ready.error().message);
        end_serving();
    });
    // Creates this thread last, because nothing would stop it if the creation of a later thread failed.
    bool served = false;
    std::jthread acceptor([&] {
        served = service.serve();
        if (served) return;
        log.error("accepting connections failed");
        end_serving();
    });
    signals.wait_for_end(reload);
    starter.request_stop();
    starter.join();
    deadline.start();
    notify(stopping(config), log);
    service.drain();
    log.info("shutting down: no new connections are accepted, requests on open ones are answered");
    acceptor.join();
    service.finish();
    log.info("stopped");
    return served && started;
}

int serve(const CommandLine& command, std::span<const char* const> arguments) {
    const Config& config = command.config;
    constexpr int kGivenBack = 1 << 20;
    give_back_freed_memory(kGivenBack);
    const ServerSignals signals;
    const Log log(config.log_format);
    for (const auto& warning : command.warnings) log.warning(warning);
    const auto service = Service::start(config, log);
    if (!service) {
        log.error(service.error().message);
        return kFailed;
    }
    log.info("listening on " + (*service)->address());
    if (const auto address = (*service)->metrics_address(); !address.empty()) log.info("metrics are at " + address);
    const auto reload_files = [&] { reload(**service, command, arguments, log); };
    return serve_until_signal(**service, signals, config, reload_files, log) ? EXIT_SUCCESS : kFailed;
}

int report_check(const CommandLine& command) {
    const auto findings = check(command);
    std::fputs(("ccdt-server " CCDT_VERSION " would run with\n" + describe(command.values) + "and finds\n" +
                describe(findings))
                   .c_str(),
               stdout);
    return would_start(findings) ? EXIT_SUCCESS : kFailed;
}

int report_health(const Config& config) {
    const auto healthy = check_health(config);
    if (!healthy) std::fprintf(stderr, "ccdt-server: %s\n", healthy.error().message.c_str());
    return healthy ? EXIT_SUCCESS : kFailed;
}

int run(std::span<const char* const> arguments) {
    const auto command = parse_command_line(arguments, environment());
    if (!command) {
        std::fprintf(stderr, "ccdt-server: %s\nTry --help.\n", command.error().message.c_str());
        return kWrongUsage;
    }
    switch (command->action) {
        case CommandLine::Action::Help:
            std::fputs(usage().c_str(), stdout);
            return EXIT_SUCCESS;
        case CommandLine::Action::Manual:
            std::fputs(manual().c_str(), stdout);
            return EXIT_SUCCESS;
        case CommandLine::Action::Version:
            std::puts("ccdt-server " CCDT_VERSION);
            return EXIT_SUCCESS;
        case CommandLine::Action::PrintConfig:
            std::fputs(config_file(command->values).c_str(), stdout);
            return EXIT_SUCCESS;
        case CommandLine::Action::Check:
            return report_check(*command);
        case CommandLine::Action::Health:
            return report_health(command->config);
        case CommandLine::Action::Serve:
            break;
    }
    return serve(*command, arguments);
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
