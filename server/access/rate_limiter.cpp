// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/access/rate_limiter.h"

#include <algorithm>

namespace ccdt::server {

using Seconds = std::chrono::duration<double>;

void RateLimiter::set_rate(const Rate& rate) {
    const std::lock_guard lock(mutex_);
    rate_ = rate;
}

std::chrono::seconds RateLimiter::take(const std::string& client, Clock::time_point now) {
    const std::lock_guard lock(mutex_);
    if (rate_.per_second <= 0) return std::chrono::seconds(0);
    Bucket& bucket = bucket_of_locked(client, now);
    const double gained = Seconds(now - bucket.filled).count() * rate_.per_second;
    bucket.tokens = std::min(bucket.tokens + std::max(gained, 0.0), static_cast<double>(rate_.burst));
    bucket.filled = std::max(bucket.filled, now);
    if (bucket.tokens >= 1) {
        bucket.tokens -= 1;
        return std::chrono::seconds(0);
    }
    return std::chrono::ceil<std::chrono::seconds>(Seconds((1 - bucket.tokens) / rate_.per_second));
}

std::size_t RateLimiter::size() const {
    const std::lock_guard lock(mutex_);
    return buckets_.size();
}

RateLimiter::Bucket& RateLimiter::bucket_of_locked(const std::string& client, Clock::time_point now) {
    const auto found = by_client_.find(client);
    if (found != by_client_.end()) {
        buckets_.splice(buckets_.begin(), buckets_, found->second);
        return buckets_.front();
    }
    if (buckets_.size() >= max_clients_) {
        by_client_.erase(buckets_.back().client);
        buckets_.pop_back();
    }
    buckets_.push_front({client, static_cast<double>(rate_.burst), now});
    by_client_.emplace(client, buckets_.begin());
    return buckets_.front();
}

}  // namespace ccdt::server
