// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/http/connection_threads.h"

#include <malloc.h>
#include <sys/mman.h>

#include <exception>
#include <iterator>
#include <new>
#include <utility>

namespace ccdt::server {
namespace {

/// Takes address space, without memory, until the destruction. Throws std::bad_alloc. (A compiler may omit an
/// allocation that is not used.)
class Reserve {
public:
    Reserve() : start_(mmap(nullptr, kBytes, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0)) {
        if (start_ == MAP_FAILED) throw std::bad_alloc();
    }
    ~Reserve() { munmap(start_, kBytes); }
    Reserve(const Reserve&) = delete;
    Reserve& operator=(const Reserve&) = delete;

private:
    static constexpr std::size_t kBytes = std::size_t{4} << 20;

    void* start_;
};

}  // namespace

ConnectionThreads::~ConnectionThreads() {
    const std::lock_guard lock(mutex_);
    closing_ = true;
    for (Thread& thread : idle_) thread.wake.notify_one();
}

bool ConnectionThreads::run(std::function<void()> task) {
    const std::lock_guard lock(mutex_);
    if (!idle_.empty()) {
        const auto next = std::prev(idle_.end());
        busy_.splice(busy_.end(), idle_, next);
        next->task = std::move(task);
        next->wake.notify_one();
        return true;
    }
    const auto before = busy_.size();
    try {
        const Reserve for_tasks;  // what the stack of the new thread leaves must suffice for them
        const auto made = busy_.emplace(busy_.end());
        made->task = std::move(task);
        made->handle = std::jthread([this, made] { work(made); });
    } catch (const std::exception&) {
        busy_.resize(before);
        return false;
    }
    return true;
}

ConnectionThreads::Counts ConnectionThreads::counts() const {
    const std::lock_guard lock(mutex_);
    return {busy_.size(), idle_.size()};
}

void ConnectionThreads::work(Threads::iterator self) {
    std::unique_lock lock(mutex_);
    while (true) {
        self->wake.wait_for(lock, idle_timeout_, [&] { return self->task || closing_; });
        if (!self->task) break;
        auto task = std::exchange(self->task, nullptr);
        lock.unlock();
        task();
        task = nullptr;
        lock.lock();
        if (closing_) return;
        idle_.splice(idle_.end(), busy_, self);
    }
    if (closing_) return;
    // A thread cannot join itself, so the next thread that ends joins it. At most one ended thread keeps its stack.
    const auto before = std::exchange(ended_, std::move(self->handle));
    idle_.erase(self);
    const bool last = idle_.empty();
    lock.unlock();
    // Returns memory to the system. Otherwise, it stays fragmented after many threads were busy.
    if (last) malloc_trim(0);
}

}  // namespace ccdt::server
