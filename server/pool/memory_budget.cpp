// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/pool/memory_budget.h"

namespace ccdt::server {

std::optional<MemoryBudget::Lease> MemoryBudget::reserve(std::size_t bytes) {
    std::size_t reserved = reserved_;
    do {
        if (bytes > total_ || reserved > total_ - bytes) return std::nullopt;
    } while (!reserved_.compare_exchange_weak(reserved, reserved + bytes));
    return Lease(this, bytes);
}

MemoryBudget::Lease MemoryBudget::reserve_unconditionally(std::size_t bytes) {
    reserved_ += bytes;
    return {this, bytes};
}

MemoryBudget::Lease::~Lease() {
    if (budget_ == nullptr || bytes_ == 0) return;
    budget_->reserved_ -= bytes_;
    if (budget_->callback_) budget_->callback_();
}

}  // namespace ccdt::server
