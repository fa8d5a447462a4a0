// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <string_view>

namespace ccdt::server {

/// A Lua script, which Redis runs atomically.
class RedisScript {
public:
    /// @param parts  parts of the script, joined in sequence
    /// @param flags  Redis' flags for scripts, separated by commas, such as `no-writes`. Without `allow-oom`, a script
    ///               fails at once while the memory of Redis is full.
    RedisScript(std::string_view flags, std::initializer_list<std::string_view> parts);

    const std::string& source() const { return source_; }
    const std::string& digest() const { return digest_; }  ///< SHA-1 by which Redis identifies the script

private:
    std::string source_;
    std::string digest_;
};

}  // namespace ccdt::server
