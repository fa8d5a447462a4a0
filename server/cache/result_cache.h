// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "api/run/options.h"
#include "server/cache/redis_cache.h"
#include "server/redis/redis_client.h"

namespace ccdt::server {

/// A cache of computed answers for repeated requests: a local LRU cache and, optionally, a Redis that servers share.
/// Thread-safe. O(1) per operation, plus the eviction of old entries.
class ResultCache {
public:
    struct Load {
        std::size_t answers = 0;
        std::size_t bytes = 0;
        std::uint64_t hits = 0;
        std::uint64_t misses = 0;
    };

    /// @param bytes   capacity of the local cache; 0: no local cache
    /// @param shared  Redis, which must outlive this object; null: none
    explicit ResultCache(std::size_t bytes, RedisClient* shared = nullptr) : max_bytes_(bytes) {
        if (shared != nullptr) shared_.emplace(*shared);
    }

    /// Finds an answer by the name that name_of_answer() computed; null if there is none.
    std::shared_ptr<const api::Answer> find(const std::string& name);

    /// Stores a copy in the local cache and in the Redis, if there is one. The local cache rejects answers above a
    /// quarter of its capacity, so that one answer cannot evict all others.
    void store(const std::string& name, const api::Answer& answer);

    /// Returns the size limit of stored bodies, in bytes.
    std::size_t largest() const { return std::max(max_bytes_ / 4, shared_ ? RedisCache::kLargest : 0); }

    Load load() const;

private:
    struct Entry {
        std::string name;
        std::shared_ptr<const api::Answer> answer;
        std::size_t bytes = 0;
    };

    std::shared_ptr<const api::Answer> find_here(const std::string& name);
    void keep_here(const std::string& name, std::shared_ptr<const api::Answer> answer);
    void add(const std::string& name, std::shared_ptr<const api::Answer> answer, std::size_t bytes);

    const std::size_t max_bytes_;
    std::optional<RedisCache> shared_;
    mutable std::mutex mutex_;  ///< guards the members below
    std::list<Entry> entries_;  ///< most recently used first
    std::unordered_map<std::string_view, std::list<Entry>::iterator>
        by_name_;  ///< keys are views of the entries' names
    Load load_;
};

}  // namespace ccdt::server
