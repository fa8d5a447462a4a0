#pragma once

#include <string>
#include <string_view>

namespace ccdt::server {

/// A program in Lua that Redis runs at once, with nothing of others in between.
class RedisScript {
public:
    /// @param parts  of the program, one after another; they declare functions, or do something
    /// @param flags  as Redis names them: what the program may do, such as `no-writes`. By default one that is begun
    ///               while the memory is full does nothing at all.
    RedisScript(std::string_view flags, std::initializer_list<std::string_view> parts);

    const std::string& source() const { return source_; }
    const std::string& digest() const { return digest_; }  ///< by which Redis knows it

private:
    std::string source_;
    std::string digest_;
};

}  // namespace ccdt::server
