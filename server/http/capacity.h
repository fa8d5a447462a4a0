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

/// The class of a connection. Each class has slots of its own, so that none takes the slots of another.
enum class ConnectionClass {
    Common,   ///< any request
    Reserve,  ///< health checks and metrics when the common slots are taken
    Streams,  ///< event streams, which last long
};

/// Counts the resources that clients take: connections, and memory for data in transfer to or from them.
///
/// Rejects connections at the hard limit. Above the soft limit, time-outs shrink. Connections that wait for a request
/// head do not keep new connections out: at the hard limit, one of the waiting connections is closed. Thread-safe.
class Capacity {
public:
    struct Limits {
        std::size_t connections = 512;               ///< common slots
        std::size_t reserve = 128;                   ///< slots in reserve, in addition
        std::size_t streams = 1024;                  ///< slots for streams, in addition
        std::size_t refused = 256;                   ///< refused clients kept connected to read the reason
        std::size_t per_address = 64;                ///< connections of one address, in all classes; 0: no limit
        std::size_t bytes = std::size_t{256} << 20;  ///< memory of bodies being read and answers being written
    };

    struct Counts {
        std::size_t open = 0;                  ///< connections, including those that stream
        std::size_t streams = 0;               ///< connections that stream
        std::uint64_t refused = 0;             ///< since the start, because the server was full
        std::uint64_t refused_by_address = 0;  ///< since the start, because of the limit of their address
        std::uint64_t refused_streams = 0;     ///< since the start, because of the limit of streams
    };

    explicit Capacity(const Limits& limits) : limits_(limits) {}

    const Limits& limits() const { return limits_; }

    void add_bytes(std::size_t bytes) { bytes_ += bytes; }
    void remove_bytes(std::size_t bytes) { bytes_ -= bytes; }

    /// Whether no further body may be read.
    bool is_out_of_memory() const { return bytes_ > limits_.bytes; }

    /// Whether time-outs of slow clients shrink: more than three quarters of the common slots, or more than half of the
    /// memory, are taken.
    bool is_pressed() const { return taken_.front() > limits_.connections / 4 * 3 || bytes_ > limits_.bytes / 2; }

    /// Shrinks the time-outs from now on, because the server is shutting down.
    void close() { closing_ = true; }
    bool is_closing() const { return closing_; }

    Counts counts() const;

    /// Closes the idle connection that comes first in IdleConnections, of any class.
    /// @returns  false if no connection is idle
    bool close_first_idle();

private:
    friend class ConnectionSlot;

    using Clock = std::chrono::steady_clock;

    /// A connection that waits for a request, for the rest of a request head, or for its client to close it.
    struct Idle {
        ConnectionSlot* slot = nullptr;
        int socket = -1;
        bool has_begun = false;  ///< part of a request head has arrived; the request can still be answered
    };
    /// Idle connections, sorted by the time from which each may be closed to make way for a new one.
    using IdleConnections = std::multimap<Clock::time_point, Idle>;

    IdleConnections::iterator first_idle_locked(std::optional<ConnectionClass> connection_class);
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
    std::condition_variable left_;  ///< a slot has become free
    IdleConnections idle_;
    std::map<std::string, std::size_t> by_address_;
    std::uint64_t refused_ = 0;
    std::uint64_t refused_by_address_ = 0;
    std::uint64_t refused_streams_ = 0;
};

/// The slot of a connection, released by the destructor.
class ConnectionSlot {
public:
    enum class Entry { Admitted, Full, AddressFull };

    /// Takes a common slot or, if that fails, a slot of the reserve. If all slots of a class are taken, closes an idle
    /// connection of that class and waits briefly until its slot is free.
    /// @param address  address by which the connection is counted; empty: none
    ConnectionSlot(Capacity& capacity, std::string address);
    ~ConnectionSlot();
    ConnectionSlot(const ConnectionSlot&) = delete;
    ConnectionSlot& operator=(const ConnectionSlot&) = delete;

    /// The decision about the connection. Only an admitted connection has a slot.
    Entry entry() const { return entry_; }

    /// The current class. Only the thread that calls move_to() may call this function.
    ConnectionClass connection_class() const { return class_; }

    /// Moves the slot to the class that the current request needs. For Reserve, the slot stays where it is, because a
    /// connection of any class may serve such requests.
    /// @returns  false if the class is full; the slot then stays in its previous class
    bool move_to(ConnectionClass connection_class);

    /// Marks the connection as idle, if it is not idle already. The socket must stay open until `end_idle`. Until then
    /// it may be shut down to make way for another connection, unless it has unread bytes.
    /// @param head_begun  time at which an incomplete request head began; none: no request has begun. A connection with
    ///                    an incomplete head has more time, and its socket is shut down for receiving only
    void begin_idle(int socket, std::optional<std::chrono::steady_clock::time_point> head_begun = {});
    void end_idle();

    /// Whether the socket was shut down to make way for another connection.
    bool is_closed() const;

    /// Counts the connection for another address from now on, or for no address if `address` is empty.
    /// @returns  false if that address is at its limit; the connection then counts as before
    bool count_by(const std::string& address);

private:
    friend class Capacity;

    Capacity& capacity_;
    std::string address_;
    Entry entry_ = Entry::Full;
    ConnectionClass class_ = ConnectionClass::Common;
    bool closed_ = false;  ///< whether the socket was shut down to make way for another connection; guarded by the
                           ///< capacity's mutex
    std::optional<Capacity::IdleConnections::iterator> idle_;  ///< guarded by the capacity's mutex
};

/// Marks a connection as idle during the lifetime of this object.
class IdleTime {
public:
    /// @param slot        null: the connection is not marked, and never closed to make way for another
    /// @param head_begun  as for ConnectionSlot::begin_idle
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

/// Counts the bytes that a connection takes in a Capacity. The destructor releases them.
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
