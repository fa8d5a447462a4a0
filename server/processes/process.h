#pragma once

#include <cstddef>
#include <optional>

namespace ccdt::server {

/// Bytes of memory that this process holds now; 0 where the system does not tell.
std::size_t resident_bytes();

/// Bytes of memory that this process may use: the machine's, or less if its control group or one of those around it
/// has less.
std::size_t available_memory();

/// Bytes of addresses that a process may have (ulimit -v); none where there is no limit.
std::optional<std::size_t> address_space_limit();

/// Has the allocator give back freed pieces of a megabyte or more. Left to itself, glibc raises its bounds as
/// large pieces come and go, up to 32 and 64 MiB in each of its arenas, and a process at rest keeps most of what its
/// busiest moment took.
void give_back_freed_memory();

/// Has all threads allocate from one heap. Left to itself, glibc gives most of them one of their own, each of which
/// keeps what was freed in it. To be called before there are threads.
void share_heap_among_threads();

std::size_t open_descriptors();
std::size_t most_descriptors();

}  // namespace ccdt::server
