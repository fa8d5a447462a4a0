#pragma once

#include <cstddef>

namespace ccdt::server {

/// What the system says of this process; 0 where it does not tell.
std::size_t resident_bytes();

/// Bytes of memory that this process may use: the machine's, or less if its control group or one of those around it
/// has less.
std::size_t available_memory();

std::size_t open_descriptors();
std::size_t most_descriptors();

}  // namespace ccdt::server
