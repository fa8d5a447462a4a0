// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <optional>
#include <utility>

namespace ccdt::server {

/// A limit for the memory of all requests together. Callers reserve estimates; real use is not measured.
///
/// Thread-safe; must outlive its leases.
class MemoryBudget {
public:
    /// Reserved bytes, released by the destructor.
    class Lease {
    public:
        Lease() = default;
        Lease(Lease&& other) noexcept
            : budget_(std::exchange(other.budget_, nullptr)), bytes_(std::exchange(other.bytes_, 0)) {}
        Lease& operator=(Lease&& other) noexcept {
            std::swap(budget_, other.budget_);
            std::swap(bytes_, other.bytes_);
            return *this;
        }
        ~Lease();

    private:
        friend class MemoryBudget;
        Lease(MemoryBudget* budget, std::size_t bytes) : budget_(budget), bytes_(bytes) {}

        MemoryBudget* budget_ = nullptr;
        std::size_t bytes_ = 0;
    };

    explicit MemoryBudget(std::size_t total) : total_(total) {}
    MemoryBudget(const MemoryBudget&) = delete;
    MemoryBudget& operator=(const MemoryBudget&) = delete;

    std::size_t total() const { return total_; }
    std::size_t reserved() const { return reserved_; }

    /// @returns  none if less than `bytes` is left
    std::optional<Lease> reserve(std::size_t bytes);

    /// Reserves unconditionally, for buffers that are already allocated and were part of a larger lease.
    Lease reserve_unconditionally(std::size_t bytes);

    /// Sets a function that is called after each release, in the releasing thread. Must be called before the first
    /// reservation.
    void on_release(std::function<void()> callback) { callback_ = std::move(callback); }

private:
    const std::size_t total_;
    std::atomic<std::size_t> reserved_ = 0;
    std::function<void()> callback_;
};

}  // namespace ccdt::server
