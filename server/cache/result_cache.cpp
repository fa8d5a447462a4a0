// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/cache/result_cache.h"

#include <new>
#include <utility>

namespace ccdt::server {
namespace {

/// Estimated bytes of an entry in addition to its texts: nodes of the list and the hash table, allocator overhead.
constexpr std::size_t kOverhead = 512;

}  // namespace

std::shared_ptr<const api::Answer> ResultCache::find(const std::string& name) {
    if (max_bytes_ == 0 && !shared_) return nullptr;  // misses are counted only if there is a cache
    auto answer = find_here(name);
    if (!answer && shared_) {
        if (auto shared = shared_->find(name)) {
            answer = std::make_shared<const api::Answer>(*std::move(shared));
            keep_here(name, answer);
        }
    }
    const std::lock_guard lock(mutex_);
    ++(answer ? load_.hits : load_.misses);
    return answer;
}

std::shared_ptr<const api::Answer> ResultCache::find_here(const std::string& name) {
    const std::lock_guard lock(mutex_);
    const auto found = by_name_.find(name);
    if (found == by_name_.end()) return nullptr;
    entries_.splice(entries_.begin(), entries_, found->second);
    return found->second->answer;
}

void ResultCache::store(const std::string& name, const api::Answer& answer) {
    if (shared_) shared_->store(name, answer);
    if (answer.body.size() > max_bytes_ / 4) return;
    try {
        keep_here(name, std::make_shared<const api::Answer>(answer));
    } catch (const std::bad_alloc&) {
        // If there is no memory, the answer is not cached.
    }
}

void ResultCache::keep_here(const std::string& name, std::shared_ptr<const api::Answer> answer) {
    const std::size_t bytes = answer->body.size() + name.size() + kOverhead;
    if (bytes <= max_bytes_ / 4) add(name, std::move(answer), bytes);
}

void ResultCache::add(const std::string& name, std::shared_ptr<const api::Answer> answer, std::size_t bytes) {
    const std::lock_guard lock(mutex_);
    if (by_name_.contains(name)) return;
    while (load_.bytes + bytes > max_bytes_) {
        load_.bytes -= entries_.back().bytes;
        by_name_.erase(entries_.back().name);
        entries_.pop_back();
    }
    entries_.push_front({name, std::move(answer), bytes});
    load_.bytes += bytes;
    load_.answers = entries_.size();
    by_name_.emplace(entries_.front().name, entries_.begin());
}

ResultCache::Load ResultCache::load() const {
    const std::lock_guard lock(mutex_);
    return load_;
}

}  // namespace ccdt::server
