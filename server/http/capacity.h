#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>

namespace ccdt::server {

/// How much of the server its clients hold: connections, and memory for what is on its way to or from them.
///
/// Says no at its limits, and well before them that it is time to be less patient. May be used from any thread.
class Capacity {
public:
    struct Limits {
        std::size_t connections = 512;
        std::size_t per_address = 64;                ///< connections of one address; 0: no limit
        std::size_t bytes = std::size_t{256} << 20;  ///< of bodies that are being read and answers being written
    };

    enum class Entry { Admitted, Full, AddressFull };

    struct Counts {
        std::size_t open = 0;
        std::uint64_t refused = 0;             ///< since the start, because the server was full
        std::uint64_t refused_by_address = 0;  ///< since the start, because their address had enough
    };

    explicit Capacity(const Limits& limits) : limits_(limits) {}

    /// Asks for a connection's place; one that was admitted has to `leave` again.
    /// @param address  empty: not counted by address
    Entry enter(const std::string& address);
    void leave(const std::string& address);

    void hold(std::size_t bytes) { bytes_ += bytes; }
    void release(std::size_t bytes) { bytes_ -= bytes; }

    /// No more bodies are to be read.
    bool is_out_of_memory() const { return bytes_ > limits_.bytes; }

    /// Three quarters of the connections or half of the memory are taken: slow clients have to make room.
    bool is_pressed() const { return open_ > limits_.connections / 4 * 3 || bytes_ > limits_.bytes / 2; }

    Counts counts() const;

private:
    const Limits limits_;
    std::atomic<std::size_t> bytes_ = 0;
    std::atomic<std::size_t> open_ = 0;  ///< written under the mutex

    mutable std::mutex mutex_;  ///< guards the rest
    std::map<std::string, std::size_t> by_address_;
    std::uint64_t refused_ = 0;
    std::uint64_t refused_by_address_ = 0;
};

/// Bytes that a connection holds, let go at the end.
class Held {
public:
    /// @param capacity  null: nobody counts
    explicit Held(Capacity* capacity) : capacity_(capacity) {}
    ~Held() { resize(0); }
    Held(const Held&) = delete;
    Held& operator=(const Held&) = delete;

    void resize(std::size_t bytes);

private:
    Capacity* const capacity_;
    std::size_t bytes_ = 0;
};

}  // namespace ccdt::server
