#pragma once

#include <algorithm>
#include <cstddef>

namespace ccdt::server {

/// Threads that each computation may have: what idles is lent, to all alike, and comes back as more begin.
/// @param workers  >= 1, that there are cores for
/// @param running  computations, those of short requests among them
/// @param most     >= 1
inline std::size_t threads_for_each(std::size_t workers, std::size_t running, std::size_t most) {
    return std::clamp<std::size_t>(workers / std::max<std::size_t>(running, 1), 1, most);
}

}  // namespace ccdt::server
