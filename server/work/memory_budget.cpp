// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/work/memory_budget.h"

namespace ccdt::server {

std::optional<MemoryBudget::Lease> MemoryBudget::take(std::size_t bytes) {
    std::size_t taken = taken_;
    do {
        if (bytes > total_ || taken > total_ - bytes) return std::nullopt;
    } while (!taken_.compare_exchange_weak(taken, taken + bytes));
    return Lease(this, bytes);
}

MemoryBudget::Lease MemoryBudget::hold(std::size_t bytes) {
    taken_ += bytes;
    return {this, bytes};
}

MemoryBudget::Lease::~Lease() {
    if (budget_ == nullptr || bytes_ == 0) return;
    budget_->taken_ -= bytes_;
    if (budget_->callback_) budget_->callback_();
}

}  // namespace ccdt::server
