// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/server/shortage.h"

#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <new>

namespace {

/// Number of allocations that succeed before one fails; negative: all succeed.
std::atomic<int> allocations_left = -1;
thread_local bool spared = false;

bool is_to_fail() {
    return !spared && allocations_left >= 0 && allocations_left-- == 0;
}

}  // namespace

// Replaces operator new. In a separate file, because GCC 12 emits false warnings if the function is inlined.
void* operator new(std::size_t size) {
    void* memory = is_to_fail() ? nullptr : std::malloc(size);
    if (memory == nullptr) throw std::bad_alloc();
    return memory;
}

void operator delete(void* memory) noexcept {
    std::free(memory);
}

void operator delete(void* memory, std::size_t) noexcept {
    std::free(memory);
}

namespace ccdt::server {

Shortage::Shortage(int number, bool here) {
    spared = !here;
    allocations_left = number;
}

Shortage::~Shortage() {
    allocations_left = -1;
    spared = false;
}

bool Shortage::is_over() const {
    return allocations_left < 0;
}

}  // namespace ccdt::server
