// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include <sys/types.h>

#include "server/redis/redis_address.h"

namespace ccdt::server::test {

/// A Redis server on a free port of this machine, with a temporary folder. The destructor ends it.
class LocalRedis {
public:
    /// @param flags  additional flags of redis-server
    explicit LocalRedis(std::vector<std::string> flags = {});
    ~LocalRedis();

    LocalRedis(const LocalRedis&) = delete;
    LocalRedis& operator=(const LocalRedis&) = delete;

    RedisAddress address() const;

    /// Kills the server. Data in its memory is lost.
    void kill();

    /// Starts the server again on the same port; returns once it replies.
    void start();

    /// Suspends and continues the server's process.
    void pause();
    void resume();

private:
    const std::vector<std::string> flags_;
    std::string folder_;
    int port_ = 0;
    pid_t process_ = -1;
};

}  // namespace ccdt::server::test
