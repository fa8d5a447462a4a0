// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <mutex>

#include "server/jobs/job_store.h"

namespace ccdt::server {

/// Holds the listener of a store, and notifies it. Thread-safe.
class JobNotifier {
public:
    /// Sets the listener; null: none. Waits until the previous listener is no longer being notified.
    void listen(JobListener* listener) {
        const std::lock_guard lock(mutex_);
        listener_ = listener;
    }

    /// Calls notify(listener) if there is a listener.
    template <class Notify>
    void notify(Notify notify) {
        const std::lock_guard lock(mutex_);
        if (listener_ != nullptr) notify(*listener_);
    }

private:
    std::mutex mutex_;  ///< guards the members below
    JobListener* listener_ = nullptr;
};

}  // namespace ccdt::server
