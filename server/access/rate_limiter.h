#pragma once

#include <chrono>
#include <cstddef>
#include <list>
#include <mutex>
#include <string>
#include <unordered_map>

namespace ccdt::server {

/// A bucket of tokens for each client: a request takes one, and they come back at a steady rate.
///
/// Remembers the 65,536 clients that asked last; whoever was forgotten has a full bucket again. May be used from any
/// thread.
class RateLimiter {
public:
    using Clock = std::chrono::steady_clock;

    struct Rate {
        double per_second = 0;   ///< 0: no limit
        std::size_t burst = 20;  ///< tokens in a full bucket
    };

    explicit RateLimiter(const Rate& rate, std::size_t most_clients = 65'536)
        : rate_(rate), most_clients_(most_clients) {}

    /// @returns  0 if the request may pass, else after how many seconds there will be a token
    std::chrono::seconds take(const std::string& client, Clock::time_point now = Clock::now());

    std::size_t size() const;

private:
    struct Bucket {
        std::string client;
        double tokens = 0;
        Clock::time_point filled;
    };

    Bucket& bucket_of_locked(const std::string& client, Clock::time_point now);

    const Rate rate_;
    const std::size_t most_clients_;

    mutable std::mutex mutex_;   ///< guards the rest
    std::list<Bucket> buckets_;  ///< who asked last comes first
    std::unordered_map<std::string, std::list<Bucket>::iterator> by_client_;
};

}  // namespace ccdt::server
