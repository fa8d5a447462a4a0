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

/// Answers that were computed, to be given again: here, where what was not asked for longest goes first, and in a Redis
/// that servers share, if there is one. May be used from any thread; O(1) an operation, but for what has to go.
class ResultCache {
public:
    struct Load {
        std::size_t answers = 0;
        std::size_t bytes = 0;
        std::uint64_t hits = 0;
        std::uint64_t misses = 0;
    };

    /// @param bytes   that answers may take; 0: none is kept here
    /// @param shared  Redis, which must outlive it; null: none
    explicit ResultCache(std::size_t bytes, RedisClient* shared = nullptr) : most_(bytes) {
        if (shared != nullptr) shared_.emplace(*shared);
    }

    /// @returns  null if there is none of that name
    std::shared_ptr<const api::Answer> find(const std::string& name);

    /// Keeps a copy, unless it would take more than a quarter of the room: one answer must not drive out all others.
    void keep(const std::string& name, const api::Answer& answer);

    /// Bytes of the largest body that is kept.
    std::size_t largest() const { return std::max(most_ / 4, shared_ ? RedisCache::kLargest : 0); }

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

    const std::size_t most_;
    std::optional<RedisCache> shared_;
    mutable std::mutex mutex_;                                                 ///< guards the rest
    std::list<Entry> entries_;                                                 ///< the latest first
    std::unordered_map<std::string_view, std::list<Entry>::iterator> places_;  ///< by the entries' own names
    Load load_;
};

}  // namespace ccdt::server
