// SPDX-License-Identifier: GPL-3.0-or-later
#include <cstddef>
#include <cstdlib>
#include <new>

namespace {

/// Allocates memory; throws std::bad_alloc above 1 GiB.
void* allocate(std::size_t size) {
    constexpr std::size_t kLimit = std::size_t{1} << 30;
    void* const memory = size <= kLimit ? std::malloc(size) : nullptr;
    if (memory == nullptr) throw std::bad_alloc();
    return memory;
}

}  // namespace

// In the decoder process, an allocation above the limit throws std::bad_alloc, which becomes an error of the request.
// The sanitizers' operators would end the process instead.
void* operator new(std::size_t size) {
    return allocate(size);
}
void* operator new[](std::size_t size) {
    return allocate(size);
}

/// Permits the sanitizer's `delete` for this memory.
extern "C" const char* __asan_default_options() {
    return "alloc_dealloc_mismatch=0";
}
