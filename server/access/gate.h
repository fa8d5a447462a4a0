#pragma once

#include <chrono>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "core/result.h"
#include "server/access/key_ring.h"
#include "server/access/rate_limiter.h"
#include "server/access/shared_rate.h"
#include "server/http/http.h"

namespace ccdt::server {

/// Decides whether a request may pass: it needs a key if there are any, and must not come too often.
///
/// The rate is counted by key, or by address for those without a good one, so that keys cannot be guessed fast. Over a
/// Unix socket clients have no address, and are not limited without a key. Browsers send no keys with preflights, which
/// need none, and count by address. May be used from any thread.
class Gate {
public:
    struct Verdict {
        std::string key;             ///< the name of the key that was shown; empty: none
        std::string client;          ///< who asks: the key or the address
        HttpResult<void> admission;  ///< why the request may not pass, if it may not
    };

    /// @param key_file  empty: no key is needed
    /// @param shared    Redis where servers count together, which must outlive it; null: each counts by itself
    Gate(std::string key_file, const RateLimiter::Rate& rate, RedisClient* shared = nullptr)
        : key_file_(std::move(key_file)), limiter_(rate) {
        if (shared != nullptr) shared_.emplace(*shared, rate);
    }

    /// Reads the file of keys, if one is configured. After an error the keys are what they were.
    Result<void> read_keys();

    /// @param is_free  needs no key, whatever it says, and does not count
    Verdict check(const Request& request, const std::string& address, bool is_free = false);

private:
    std::shared_ptr<const KeyRing> keys() const;
    std::chrono::seconds take(const std::string& client);

    const std::string key_file_;
    RateLimiter limiter_;
    std::optional<SharedRate> shared_;

    mutable std::mutex mutex_;  ///< guards the keys
    std::shared_ptr<const KeyRing> keys_;
};

}  // namespace ccdt::server
