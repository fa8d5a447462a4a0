// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <optional>

namespace ccdt::server {

/// Resident memory of this process in bytes; 0 if it is unknown.
std::size_t resident_bytes();

/// Memory limit of this process in bytes: the lowest among the memory of the machine and the limits of its control
/// group and the enclosing groups.
std::size_t available_memory();

/// Limit of the address space in bytes (ulimit -v); none if there is no limit.
std::optional<std::size_t> address_space_limit();

/// Makes the allocator return freed blocks of at least this size to the system. By default, when large blocks are
/// freed, glibc raises its thresholds for mapping and trimming up to 32 and 64 MiB in each arena. Then an idle process
/// keeps most of its peak memory.
void give_back_freed_memory(int bytes);

/// Makes all threads allocate from one heap. By default, glibc gives most threads their own arena, which keeps freed
/// memory. Must be called before threads are created.
void share_heap_among_threads();

std::size_t open_descriptors();
std::size_t max_descriptors();

}  // namespace ccdt::server
