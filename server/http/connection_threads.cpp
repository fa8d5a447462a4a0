#include "server/http/connection_threads.h"

#include <exception>
#include <utility>

namespace ccdt::server {

bool ConnectionThreads::run(std::function<void()> task) {
    const std::lock_guard lock(mutex_);
    const auto before = tasks_.size();
    try {
        tasks_.push_back(std::move(task));
        if (idle_ < tasks_.size()) threads_.emplace_back([this](const std::stop_token& closing) { work(closing); });
    } catch (const std::exception&) {
        tasks_.resize(before);
        return false;
    }
    task_waits_.notify_one();
    return true;
}

void ConnectionThreads::work(const std::stop_token& closing) {
    std::unique_lock lock(mutex_);
    while (true) {
        ++idle_;
        const bool found = task_waits_.wait(lock, closing, [this] { return !tasks_.empty(); });
        --idle_;
        if (!found) return;
        auto task = std::move(tasks_.front());
        tasks_.pop_front();
        lock.unlock();
        task();
        task = nullptr;
        lock.lock();
    }
}

}  // namespace ccdt::server
