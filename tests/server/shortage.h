// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace ccdt::server {

/// Makes one allocation fail during the lifetime of this object, in any thread except the creating one. Linking this
/// class replaces operator new.
class Shortage {
public:
    /// @param number  number of allocations that succeed before the failure
    /// @param here    whether allocations of the creating thread count and may fail, too
    explicit Shortage(int number, bool here = false);
    ~Shortage();

    Shortage(const Shortage&) = delete;
    Shortage& operator=(const Shortage&) = delete;

    /// Whether the allocation has failed.
    bool is_over() const;
};

}  // namespace ccdt::server
