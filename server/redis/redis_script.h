// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

namespace ccdt::server {

/// A program in Lua that Redis runs atomically.
class RedisScript {
public:
    /// @param parts  parts of the program, in order; each declares functions or executes statements
    /// @param flags  flags of Redis that say what the program may do, such as `no-writes`. Without flags, a program
    ///               that is started while the memory is full fails at once.
    RedisScript(std::string_view flags, std::initializer_list<std::string_view> parts);

    const std::string& source() const { return source_; }
    const std::string& digest() const { return digest_; }  ///< the digest by which Redis identifies the script

private:
    std::string source_;
    std::string digest_;
};

}  // namespace ccdt::server
