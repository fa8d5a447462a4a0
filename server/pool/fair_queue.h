// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace ccdt::server {

/// A fair queue for the items of several clients. The next item belongs to the client that has received the least
/// service, which is the total cost of its items. The cost of an item is an estimate until charge() corrects it. An
/// idle client gains no credit. When the queue becomes empty, it forgets the service received.
///
/// Not thread-safe. O(items) per operation.
/// Source: Goyal, Vin, Cheng 1996, Start-time fair queuing.
template <class Item>
class FairQueue {
public:
    struct Entry {
        std::string client;
        double cost = 0;
        double start_tag = 0;          ///< virtual time at which the service of this item may start
        std::uint64_t generation = 0;  ///< see generation()
        Item item;
    };

    bool empty() const { return entries_.empty(); }
    std::size_t size() const { return entries_.size(); }
    auto begin() const { return entries_.begin(); }  ///< in order of arrival
    auto end() const { return entries_.end(); }

    bool has(std::string_view client) const {
        return std::ranges::find(entries_, client, &Entry::client) != entries_.end();
    }

    void push(const std::string& client, double cost, Item item) {
        double& finish_tag = finish_tags_.try_emplace(client, virtual_time_).first->second;
        const double start_tag = std::max(virtual_time_, finish_tag);
        finish_tag = start_tag + cost;
        entries_.push_back({client, cost, start_tag, generation_, std::move(item)});
    }

    /// Returns the number of times that the queue has forgotten the service received.
    std::uint64_t generation() const { return generation_; }

    /// Replaces the estimated cost of an item that was taken by its real cost. Also moves the waiting items of the
    /// client. An empty queue ignores the call.
    /// @param generation  generation in which the item was added; in a later one, its estimate is already forgotten
    void charge(const std::string& client, std::uint64_t generation, double estimate, double cost) {
        if (empty()) return;
        const double more = generation == generation_ ? cost - estimate : cost;
        finish_tags_.try_emplace(client, virtual_time_).first->second += more;
        for (Entry& entry : entries_)
            if (entry.client == client) entry.start_tag += more;
    }

    /// Returns the first entry with the lowest start tag. The queue must not be empty.
    const Entry& next() const { return *std::ranges::min_element(entries_, {}, &Entry::start_tag); }

    Item take_next() {
        const auto next = std::ranges::min_element(entries_, {}, &Entry::start_tag);
        advance(next->start_tag);
        return remove(next);
    }

    /// Takes the entry with the lowest start tag among the entries whose items pass a test.
    /// @returns  none if there is none
    template <class Test>
    std::optional<Entry> take_next_of(Test test) {
        auto next = entries_.end();
        for (auto entry = entries_.begin(); entry != entries_.end(); ++entry)
            if (test(entry->item) && (next == entries_.end() || entry->start_tag < next->start_tag)) next = entry;
        if (next == entries_.end()) return std::nullopt;
        advance(next->start_tag);
        Entry taken{next->client, next->cost, next->start_tag, next->generation, {}};
        taken.item = remove(next);
        return taken;
    }

    /// Puts an entry that was taken back at the front of the queue.
    void put_back(Entry entry) {
        entry.start_tag = std::min(entry.start_tag, virtual_time_);
        entries_.push_front(std::move(entry));
    }

    /// Removes the first item that passes a test. The client is not charged for the item.
    /// @returns  none if there is none
    template <class Test>
    std::optional<Item> withdraw(Test test) {
        const auto found = std::ranges::find_if(entries_, test, &Entry::item);
        if (found == entries_.end()) return std::nullopt;
        if (const auto finish_tag = finish_tags_.find(found->client); finish_tag != finish_tags_.end())
            finish_tag->second -= found->cost;
        return remove(found);
    }

private:
    /// Advances the virtual time to the start tag of an entry that is taken.
    void advance(double start_tag) {
        virtual_time_ = std::max(virtual_time_, start_tag);
        std::erase_if(finish_tags_, [this](const auto& client) { return client.second <= virtual_time_; });
    }

    Item remove(typename std::deque<Entry>::iterator entry) {
        Item item = std::move(entry->item);
        entries_.erase(entry);
        if (entries_.empty()) {
            finish_tags_.clear();
            virtual_time_ = 0;
            ++generation_;
        }
        return item;
    }

    std::deque<Entry> entries_;
    std::uint64_t generation_ = 0;
    double virtual_time_ = 0;                                 ///< highest start tag of the entries taken so far
    std::map<std::string, double, std::less<>> finish_tags_;  ///< finish tags of clients, if above the virtual time
};

}  // namespace ccdt::server
