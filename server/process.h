#pragma once

#include <cstddef>

namespace ccdt::server {

/// What the system says of this process; 0 where it does not tell.
std::size_t resident_bytes();
std::size_t open_descriptors();
std::size_t most_descriptors();

}  // namespace ccdt::server
