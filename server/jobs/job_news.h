#pragma once

#include <mutex>

#include "server/jobs/job_store.h"

namespace ccdt::server {

/// The listener of a store, if there is one. May be used from any thread.
class JobNews {
public:
    /// Returns once the last listener is not told any more.
    void listen(JobListener* listener) {
        const std::lock_guard lock(mutex_);
        listener_ = listener;
    }

    template <class Tell>
    void tell(Tell tell) {
        const std::lock_guard lock(mutex_);
        if (listener_ != nullptr) tell(*listener_);
    }

private:
    std::mutex mutex_;  ///< guards the rest
    JobListener* listener_ = nullptr;
};

}  // namespace ccdt::server
