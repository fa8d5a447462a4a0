// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace ccdt::server {

/// While it lives, one allocation fails in any thread but its own. Linking it replaces operator new.
class Shortage {
public:
    /// @param number  of allocations before the one that fails
    /// @param here    in its own thread, too
    explicit Shortage(int number, bool here = false);
    ~Shortage();

    Shortage(const Shortage&) = delete;
    Shortage& operator=(const Shortage&) = delete;

    /// The allocation has failed.
    bool is_over() const;
};

}  // namespace ccdt::server
