// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <cstddef>
#include <list>
#include <mutex>
#include <string>
#include <unordered_map>

namespace ccdt::server {

/// A token bucket for each client. A request takes one token; tokens are refilled at a constant rate.
///
/// Stores buckets of the `max_clients` most recent clients. Other clients start with a full bucket. Thread-safe.
class RateLimiter {
public:
    using Clock = std::chrono::steady_clock;

    struct Rate {
        double per_second = 0;   ///< tokens per second; 0: no limit
        std::size_t burst = 20;  ///< capacity of a bucket, in tokens
    };

    explicit RateLimiter(const Rate& rate, std::size_t max_clients = 65'536) : max_clients_(max_clients), rate_(rate) {}

    /// Changes the rate. Buckets keep their tokens, up to the new capacity.
    void set_rate(const Rate& rate);

    /// Takes a token for a request.
    /// @returns  0 if a token was available, otherwise the number of seconds until one is
    std::chrono::seconds take(const std::string& client, Clock::time_point now = Clock::now());

    std::size_t size() const;

private:
    struct Bucket {
        std::string client;
        double tokens = 0;
        Clock::time_point filled;
    };

    Bucket& bucket_of_locked(const std::string& client, Clock::time_point now);

    const std::size_t max_clients_;

    mutable std::mutex mutex_;  ///< guards the members below
    Rate rate_;
    std::list<Bucket> buckets_;  ///< most recent client first
    std::unordered_map<std::string, std::list<Bucket>::iterator> by_client_;
};

}  // namespace ccdt::server
