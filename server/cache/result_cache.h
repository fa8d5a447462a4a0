#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <unordered_map>
#include <utility>

#include "api/run/options.h"

namespace ccdt::server {

/// Answers that were computed, to be given again. What was not asked for longest goes first. May be used from any
/// thread; O(1) an operation, but for what has to go.
class ResultCache {
public:
    struct Load {
        std::size_t answers = 0;
        std::size_t bytes = 0;
        std::uint64_t hits = 0;
        std::uint64_t misses = 0;
    };

    /// @param bytes  that answers may take; 0: none is kept
    explicit ResultCache(std::size_t bytes) : most_(bytes) {}

    /// @returns  null if there is none of that name
    std::shared_ptr<const api::Answer> find(const std::string& name);

    /// Keeps a copy, unless it would take more than a quarter of the room: one answer must not drive out all others.
    void keep(const std::string& name, const api::Answer& answer);

    Load load() const;

private:
    struct Entry {
        std::string name;
        std::shared_ptr<const api::Answer> answer;
        std::size_t bytes = 0;
    };

    void add(const std::string& name, std::shared_ptr<const api::Answer> answer, std::size_t bytes);

    const std::size_t most_;
    mutable std::mutex mutex_;                                                 ///< guards the rest
    std::list<Entry> entries_;                                                 ///< the latest first
    std::unordered_map<std::string_view, std::list<Entry>::iterator> places_;  ///< by the entries' own names
    Load load_;
};

}  // namespace ccdt::server
