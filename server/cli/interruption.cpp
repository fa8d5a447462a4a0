// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/cli/interruption.h"

#include <utility>

#include <pthread.h>
#include <unistd.h>

namespace ccdt::server {

Interruption::Interruption() {
    sigemptyset(&signals_);
    for (const int number : {SIGHUP, SIGINT, SIGQUIT, SIGTERM}) {
        struct sigaction action {};
        sigaction(number, nullptr, &action);
        // A signal that is ignored, as SIGHUP is below nohup, stays ignored.
        if (action.sa_handler != SIG_IGN) sigaddset(&signals_, number);
    }
    sigaddset(&signals_, SIGUSR1);  // ends the watcher
    pthread_sigmask(SIG_BLOCK, &signals_, &before_);
    watcher_ = std::jthread([this](const std::stop_token& stop) { wait_for_signals(stop); });
}

Interruption::~Interruption() {
    watcher_.request_stop();
    pthread_kill(watcher_.native_handle(), SIGUSR1);
    watcher_.join();
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
}

std::string Interruption::create_file(const std::function<std::string()>& create) {
    const std::lock_guard lock(mutex_);
    return file_ = create();
}

void Interruption::release_file() {
    const std::lock_guard lock(mutex_);
    file_.clear();
}

void Interruption::set_last_words(std::string text) {
    const std::lock_guard lock(mutex_);
    last_words_ = std::move(text);
}

void Interruption::wait_for_signals(const std::stop_token& stop) {
    while (true) {
        int number = 0;
        if (sigwait(&signals_, &number) != 0) continue;
        if (stop.stop_requested()) return;
        if (number == SIGUSR1) continue;
        // The lock stays held until the end of the process, so that no further file is created.
        const std::lock_guard lock(mutex_);
        if (!file_.empty()) unlink(file_.c_str());
        if (!last_words_.empty()) static_cast<void>(!write(STDERR_FILENO, last_words_.data(), last_words_.size()));
        std::signal(number, SIG_DFL);
        sigset_t only;
        sigemptyset(&only);
        sigaddset(&only, number);
        pthread_sigmask(SIG_UNBLOCK, &only, nullptr);
        raise(number);
    }
}

}  // namespace ccdt::server
