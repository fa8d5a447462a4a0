// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>

namespace ccdt::server {

class ConnectionSlot;

/// The class of a connection. Each class has its own limit of open connections, counted in slots.
enum class ConnectionClass {
    Common,   ///< any request
    Reserve,  ///< health checks and metrics, while all common slots are taken
    Streams,  ///< event streams, which last long
};

/// Counts the connections of clients, and the memory for data in transfer to or from them. If all slots are taken,
/// closes an idle connection in favour of a new one. Rejects the new connection if no slot becomes free. Reports the
/// load above which time-outs should be shorter. Thread-safe.
class Capacity {
public:
    struct Limits {
        std::size_t connections = 512;  ///< common slots
        std::size_t reserve = 128;      ///< additional slots for health checks and metrics
        std::size_t streams = 1024;     ///< additional slots for event streams
        std::size_t refused = 256;      ///< refused connections kept open, so that clients can read the reason
        std::size_t per_address = 64;   ///< connections of one address, in all classes; 0: no limit
        std::size_t bytes = std::size_t{256} << 20;  ///< memory for bodies being read and answers being written
    };

    struct Counts {
        std::size_t open = 0;                  ///< all connections, event streams included
        std::size_t streams = 0;               ///< event streams
        std::uint64_t refused = 0;             ///< connections refused because the server was full
        std::uint64_t refused_by_address = 0;  ///< connections refused because of the limit per address
        std::uint64_t refused_streams = 0;     ///< event streams refused because of their limit
    };

    explicit Capacity(const Limits& limits) : limits_(limits) {}

    const Limits& limits() const { return limits_; }

    void add_bytes(std::size_t bytes) { bytes_ += bytes; }
    void remove_bytes(std::size_t bytes) { bytes_ -= bytes; }

    /// Whether data in transfer exceeds the memory limit. If so, no further body may be read.
    bool is_out_of_memory() const { return bytes_ > limits_.bytes; }

    /// Whether more than three quarters of the common slots, or more than half of the memory, are taken. If so, slow
    /// clients get shorter time-outs.
    bool is_pressed() const { return taken_.front() > limits_.connections / 4 * 3 || bytes_ > limits_.bytes / 2; }

    /// Records that the server is shutting down. From now on, slow clients get shorter time-outs.
    void close() { closing_ = true; }
    bool is_closing() const { return closing_; }

    Counts counts() const;

    /// Closes one idle connection without unread bytes, of any class: the one whose minimum idle time ends first, or
    /// has ended first. It is closed even if this time has not ended yet.
    /// @returns  false if there is no such connection
    bool close_first_idle();

private:
    friend class ConnectionSlot;

    using Clock = std::chrono::steady_clock;

    /// A connection that waits for a request, for the rest of a request head, or for the client to disconnect.
    struct Idle {
        ConnectionSlot* slot = nullptr;
        int socket = -1;
        bool has_begun = false;  ///< part of a request head has arrived; the socket is shut down for receiving only
    };
    /// Idle connections, sorted by the end of their minimum idle time. After that time, a connection may be closed in
    /// favour of a new one.
    using IdleConnections = std::multimap<Clock::time_point, Idle>;

    IdleConnections::iterator first_idle_locked(std::optional<ConnectionClass> connection_class);
    bool has_idle_locked(ConnectionClass connection_class) const;
    void close_locked(IdleConnections::iterator idle);
    bool free_slot(ConnectionClass connection_class, std::unique_lock<std::mutex>& lock);
    std::optional<ConnectionClass> find_class(std::unique_lock<std::mutex>& lock);
    std::size_t limit(ConnectionClass connection_class) const;
    std::atomic<std::size_t>& taken(ConnectionClass connection_class) {
        return taken_[static_cast<std::size_t>(connection_class)];
    }
    bool has_slot_locked(ConnectionClass connection_class) { return taken(connection_class) < limit(connection_class); }
    bool enter_locked(const std::string& address);
    void leave_locked(const std::string& address);

    const Limits limits_;
    std::atomic<bool> closing_ = false;
    std::atomic<std::size_t> bytes_ = 0;
    std::array<std::atomic<std::size_t>, 3> taken_{};  ///< taken slots of each class; written while `mutex_` is held

    mutable std::mutex mutex_;      ///< guards the members below
    std::condition_variable left_;  ///< signalled when a slot becomes free
    IdleConnections idle_;
    std::map<std::string, std::size_t> by_address_;
    std::uint64_t refused_ = 0;
    std::uint64_t refused_by_address_ = 0;
    std::uint64_t refused_streams_ = 0;
};

/// Takes a slot of a Capacity for one connection. The destructor releases the slot.
class ConnectionSlot {
public:
    enum class Entry { Admitted, Full, AddressFull };

    /// Takes a common slot or, if there is none, a reserve slot. If all slots of a class are taken, closes an idle
    /// connection of that class and waits up to a second for its slot.
    /// @param address  client address, for the limit per address; empty: the limit does not apply
    ConnectionSlot(Capacity& capacity, std::string address);
    ~ConnectionSlot();
    ConnectionSlot(const ConnectionSlot&) = delete;
    ConnectionSlot& operator=(const ConnectionSlot&) = delete;

    /// Whether the connection was admitted. Only an admitted connection has a slot.
    Entry entry() const { return entry_; }

    /// Returns the current class. Not thread-safe: call it only on the thread that calls move_to().
    ConnectionClass connection_class() const { return class_; }

    /// Moves the slot to the class that the current request needs. Does nothing for Reserve, because a connection of
    /// any class may serve health checks and metrics.
    /// @returns  false if the class is full; the slot then stays in its previous class
    bool move_to(ConnectionClass connection_class);

    /// Marks the connection as idle, unless it is idle already. The socket must stay open until `end_idle`. Until then,
    /// the Capacity may shut down the socket in favour of another connection, unless the socket has unread bytes.
    /// @param head_begun  time at which an incomplete request head began; none: no request has begun. An incomplete
    ///                    head increases the minimum idle time, and its socket is shut down for receiving only
    void begin_idle(int socket, std::optional<std::chrono::steady_clock::time_point> head_begun = {});
    void end_idle();

    /// Whether the Capacity has shut down the socket in favour of another connection.
    bool is_closed() const;

    /// Counts the connection towards the limit of `address` instead of the previous address.
    /// @param address  empty: the connection counts towards no limit
    /// @returns        false if that address is at its limit; nothing is changed then
    bool count_by(const std::string& address);

private:
    friend class Capacity;

    Capacity& capacity_;
    std::string address_;
    Entry entry_ = Entry::Full;
    ConnectionClass class_ = ConnectionClass::Common;
    bool closed_ = false;  ///< the socket was shut down for another connection; guarded by the capacity's mutex
    std::optional<Capacity::IdleConnections::iterator> idle_;  ///< guarded by the capacity's mutex
};

/// Marks a connection as idle during the lifetime of this object.
class IdleTime {
public:
    /// @param slot        null: does nothing
    /// @param head_begun  see ConnectionSlot::begin_idle
    IdleTime(ConnectionSlot* slot, int socket, std::optional<std::chrono::steady_clock::time_point> head_begun = {})
        : slot_(slot) {
        if (slot_ != nullptr) slot_->begin_idle(socket, head_begun);
    }
    ~IdleTime() {
        if (slot_ != nullptr) slot_->end_idle();
    }
    IdleTime(const IdleTime&) = delete;
    IdleTime& operator=(const IdleTime&) = delete;

private:
    ConnectionSlot* const slot_;
};

/// Adds the memory that a connection uses to the count of a Capacity. The destructor subtracts it.
class CountedBytes {
public:
    /// @param capacity  null: nothing is counted
    explicit CountedBytes(Capacity* capacity) : capacity_(capacity) {}
    ~CountedBytes() { resize(0); }
    CountedBytes(const CountedBytes&) = delete;
    CountedBytes& operator=(const CountedBytes&) = delete;

    void resize(std::size_t bytes);

private:
    Capacity* const capacity_;
    std::size_t bytes_ = 0;
};

}  // namespace ccdt::server
