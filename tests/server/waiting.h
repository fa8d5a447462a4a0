// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <future>
#include <string>
#include <thread>

namespace ccdt::server::test {

/// Time limit of a wait in a test, below the time limit of the test itself. Only a fault makes a test wait this long.
inline constexpr std::chrono::seconds kPatience{45};

/// Returns the failure of a wait, with a message.
/// @param what  the event that did not occur
inline testing::AssertionResult waited_in_vain(const std::string& what) {
    return testing::AssertionFailure() << "waited for " << kPatience.count() << " s for " << what;
}

/// Waits until a condition holds.
/// @param what  describes the condition in the message of a failure
template <class Condition>
testing::AssertionResult wait_until(const std::string& what, const Condition& condition) {
    const auto deadline = std::chrono::steady_clock::now() + kPatience;
    while (!condition()) {
        if (std::chrono::steady_clock::now() > deadline) return waited_in_vain(what);
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    return testing::AssertionSuccess();
}

/// Waits until a std::future or std::shared_future is ready.
template <class Future>
testing::AssertionResult wait_for(const std::string& what, const Future& future) {
    if (future.wait_for(kPatience) != std::future_status::ready) return waited_in_vain(what);
    return testing::AssertionSuccess();
}

}  // namespace ccdt::server::test
