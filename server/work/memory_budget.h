#pragma once

#include <atomic>
#include <cstddef>
#include <functional>
#include <optional>
#include <utility>

namespace ccdt::server {

/// Bytes that requests may take together. What is taken is an estimate made before; nobody measures.
///
/// May be used from any thread; must outlive its leases.
class MemoryBudget {
public:
    /// Bytes that were taken, given back at its end.
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
    std::size_t taken() const { return taken_; }

    /// @returns  none if not so much is left
    std::optional<Lease> take(std::size_t bytes);

    /// Takes even what is not left: for what is there already, and was part of a larger lease.
    Lease hold(std::size_t bytes);

    /// Has it told whenever bytes are given back, by the thread that does. To be called before any are taken.
    void on_return(std::function<void()> tell) { tell_ = std::move(tell); }

private:
    const std::size_t total_;
    std::atomic<std::size_t> taken_ = 0;
    std::function<void()> tell_;
};

}  // namespace ccdt::server
