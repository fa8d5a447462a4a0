// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>
#include <vector>

#include <sys/types.h>

#include "server/redis/redis_address.h"

namespace ccdt::server::test {

/// A Redis on a free port of this machine, with a folder of its own. Ends with its owner.
class LocalRedis {
public:
    /// @param flags  as redis-server takes them
    explicit LocalRedis(std::vector<std::string> flags = {});
    ~LocalRedis();

    LocalRedis(const LocalRedis&) = delete;
    LocalRedis& operator=(const LocalRedis&) = delete;

    RedisAddress address() const;

    /// Has it end as by a fault. What it keeps only in memory is lost.
    void kill();

    /// Starts it where it was; returns once it answers.
    void start();

    /// Keeps it from doing anything, and lets it go on.
    void pause();
    void resume();

private:
    const std::vector<std::string> flags_;
    std::string folder_;
    int port_ = 0;
    pid_t process_ = -1;
};

}  // namespace ccdt::server::test
