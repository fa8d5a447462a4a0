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

class Place;

/// Purposes that a connection has its place for. Each has places of its own, so that none takes another's.
enum class Room {
    Common,   ///< whatever is asked
    Reserve,  ///< what takes next to nothing, health checks and figures, once the common places are taken
    Streams,  ///< streams of events, which last
};

/// Counts how much of the server its clients hold: connections, memory for what is on its way to or from them.
///
/// Says no at its limits, and well before them that it is time to be less patient. Connections without a whole request
/// head do not keep others out: at the limit, one of them is closed. May be used from any thread.
class Capacity {
public:
    struct Limits {
        std::size_t connections = 512;               ///< common places
        std::size_t reserve = 128;                   ///< further ones
        std::size_t streams = 1024;                  ///< and those of streams
        std::size_t refused = 256;                   ///< refused clients who are given time to read why
        std::size_t per_address = 64;                ///< connections of one address, wherever; 0: no limit
        std::size_t bytes = std::size_t{256} << 20;  ///< of bodies that are being read and answers being written
    };

    struct Counts {
        std::size_t open = 0;                  ///< connections, with those that stream
        std::size_t streams = 0;               ///< among them
        std::uint64_t refused = 0;             ///< since the start, because the server was full
        std::uint64_t refused_by_address = 0;  ///< since the start, because their address had enough
        std::uint64_t refused_streams = 0;     ///< since the start, because there were enough
    };

    explicit Capacity(const Limits& limits) : limits_(limits) {}

    const Limits& limits() const { return limits_; }

    void hold(std::size_t bytes) { bytes_ += bytes; }
    void release(std::size_t bytes) { bytes_ -= bytes; }

    /// Whether no more bodies are to be read.
    bool is_out_of_memory() const { return bytes_ > limits_.bytes; }

    /// Whether slow clients have to make room: three quarters of the common places or half of the memory are taken.
    bool is_pressed() const { return taken_.front() > limits_.connections / 4 * 3 || bytes_ > limits_.bytes / 2; }

    /// Has slow clients make room whatever is taken from now on: the server is about to end.
    void close() { closing_ = true; }
    bool is_closing() const { return closing_; }

    Counts counts() const;

    /// Closes the idle connection that may be closed first, whichever place it has.
    /// @returns  false if none is idle
    bool close_first_idle();

private:
    friend class Place;

    using Clock = std::chrono::steady_clock;

    /// A connection that waits for a request, for the rest of a request's head, or for its client to leave.
    struct Idle {
        Place* place = nullptr;
        int socket = -1;
        bool has_begun = false;  ///< a request of which the head is incomplete; it can still be answered
    };
    /// [time from which it may be closed for a newcomer]
    using IdleConnections = std::multimap<Clock::time_point, Idle>;

    IdleConnections::iterator first_idle_locked(std::optional<Room> room);
    void close_locked(IdleConnections::iterator idle);
    bool free_place(Room room, std::unique_lock<std::mutex>& lock);
    std::optional<Room> find_room(std::unique_lock<std::mutex>& lock);
    std::size_t limit(Room room) const;
    std::atomic<std::size_t>& taken(Room room) { return taken_[static_cast<std::size_t>(room)]; }
    bool has_place_locked(Room room) { return taken(room) < limit(room); }
    bool enter_locked(const std::string& address);
    void leave_locked(const std::string& address);

    const Limits limits_;
    std::atomic<bool> closing_ = false;
    std::atomic<std::size_t> bytes_ = 0;
    std::array<std::atomic<std::size_t>, 3> taken_{};  ///< places of each room; written under the mutex

    mutable std::mutex mutex_;      ///< guards the rest
    std::condition_variable left_;  ///< a place is free again
    IdleConnections idle_;
    std::map<std::string, std::size_t> by_address_;
    std::uint64_t refused_ = 0;
    std::uint64_t refused_by_address_ = 0;
    std::uint64_t refused_streams_ = 0;
};

/// A connection's place, given back at the end.
class Place {
public:
    enum class Entry { Admitted, Full, AddressFull };

    /// Asks for one: a common one, or else one of the reserve. If all are taken, waits for a moment until an idle
    /// connection that is closed for it has left.
    /// @param address  empty: not counted by address
    Place(Capacity& capacity, std::string address);
    ~Place();
    Place(const Place&) = delete;
    Place& operator=(const Place&) = delete;

    /// Whether it is admitted: only then there is a place.
    Entry entry() const { return entry_; }

    /// Room that the place is in now. May be asked by the thread that moves it.
    Room room() const { return room_; }

    /// Moves the place to where the current request needs it; any will do for what the reserve is for.
    /// @returns  false if that room is full; the place is then where it was
    bool move_to(Room room);

    /// Marks the connection as idle, unless it is already: until `end_idle` its socket may be shut down for the sake of
    /// another connection, unless it has unread bytes. The socket must stay open as long.
    /// @param head_begun  when the head began of which the rest is waited for; none: no request has begun. Such a head
    ///                    has more time, and its socket is shut down for receiving only
    void begin_idle(int socket, std::optional<std::chrono::steady_clock::time_point> head_begun = {});
    void end_idle();

    /// Whether its socket was shut down for the sake of another connection.
    bool is_closed() const;

    /// Counts the place by another address from now on; an empty one: by none.
    /// @returns  false if that has enough; the place then counts as it did
    bool count_by(const std::string& address);

private:
    friend class Capacity;

    Capacity& capacity_;
    std::string address_;
    Entry entry_ = Entry::Full;
    Room room_ = Room::Common;
    bool closed_ = false;  ///< for the sake of another; guarded by the capacity's mutex
    std::optional<Capacity::IdleConnections::iterator> idle_;  ///< likewise
};

/// Time during which a connection is idle.
class IdleTime {
public:
    /// @param place  null: nobody closes the connection
    /// @param head_begun  as for Place::begin_idle
    IdleTime(Place* place, int socket, std::optional<std::chrono::steady_clock::time_point> head_begun = {})
        : place_(place) {
        if (place_ != nullptr) place_->begin_idle(socket, head_begun);
    }
    ~IdleTime() {
        if (place_ != nullptr) place_->end_idle();
    }
    IdleTime(const IdleTime&) = delete;
    IdleTime& operator=(const IdleTime&) = delete;

private:
    Place* const place_;
};

/// Bytes that a connection holds, released at the end.
class HeldBytes {
public:
    /// @param capacity  null: nobody counts
    explicit HeldBytes(Capacity* capacity) : capacity_(capacity) {}
    ~HeldBytes() { resize(0); }
    HeldBytes(const HeldBytes&) = delete;
    HeldBytes& operator=(const HeldBytes&) = delete;

    void resize(std::size_t bytes);

private:
    Capacity* const capacity_;
    std::size_t bytes_ = 0;
};

}  // namespace ccdt::server
