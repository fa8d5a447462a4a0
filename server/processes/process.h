// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <cstddef>
#include <optional>

namespace ccdt::server {

/// Returns the resident memory of this process in bytes; 0 if unknown.
std::size_t resident_bytes();

/// Returns the memory limit of this process in bytes: the memory of the machine, or a lower limit of its control
/// groups.
std::size_t available_memory();

/// Returns the limit of the address space in bytes (ulimit -v); none if there is no limit.
std::optional<std::size_t> address_space_limit();

/// Makes the allocator return freed blocks of at least this size to the system. By default, glibc raises its thresholds
/// for mapping and trimming when large blocks are freed. An idle process would then keep most of its peak memory.
void give_back_freed_memory(int bytes);

/// Makes all threads allocate from one heap. By default, glibc gives most threads separate arenas, which keep freed
/// memory. Must be called before threads are created.
void share_heap_among_threads();

/// Returns the processor time of this process, over all threads.
std::chrono::microseconds processor_time();

std::size_t open_descriptors();
std::size_t max_descriptors();

}  // namespace ccdt::server
