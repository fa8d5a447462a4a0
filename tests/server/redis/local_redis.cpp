// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/server/redis/local_redis.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <thread>

#include <gtest/gtest.h>

#include "server/redis/redis_connection.h"
#include "tests/server/waiting.h"

namespace ccdt::server::test {
namespace {

/// Program that behaves as redis-server if its first argument has this name. Debian's redis-server is a link to it. Its
/// package starts no daemon, unlike the package redis-server.
constexpr const char* kProgram = "/usr/bin/redis-check-rdb";

int free_port() {
    const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof(address);
    EXPECT_EQ(bind(socket, reinterpret_cast<sockaddr*>(&address), size), 0);
    EXPECT_EQ(getsockname(socket, reinterpret_cast<sockaddr*>(&address), &size), 0);
    close(socket);
    return ntohs(address.sin_port);
}

}  // namespace

LocalRedis::LocalRedis(std::vector<std::string> flags)
    : flags_(std::move(flags)),
      folder_(std::filesystem::path(testing::TempDir()) / "redis-XXXXXX"),
      port_(free_port()) {
    EXPECT_NE(mkdtemp(folder_.data()), nullptr);
    start();
}

LocalRedis::~LocalRedis() {
    kill();
    std::filesystem::remove_all(folder_);
}

RedisAddress LocalRedis::address() const {
    RedisAddress address;
    address.host = "127.0.0.1";
    address.port = std::to_string(port_);
    return address;
}

void LocalRedis::start() {
    std::vector<std::string> texts{
        "redis-server", "--port", std::to_string(port_), "--bind", "127.0.0.1", "--dir", folder_,
        "--save",       "",       "--logfile",           "log"};
    texts.insert(texts.end(), flags_.begin(), flags_.end());
    std::vector<char*> arguments;
    for (std::string& text : texts) arguments.push_back(text.data());
    arguments.push_back(nullptr);
    process_ = fork();
    if (process_ == 0) {
        prctl(PR_SET_PDEATHSIG, SIGKILL);
        execv(kProgram, arguments.data());
        _exit(127);
    }
    const auto until = RedisConnection::Clock::now() + test::kPatience;
    while (true) {
        auto connection = RedisConnection::open(address(), until);
        if (connection || connection.error().message.find("NOAUTH") != std::string::npos) return;
        ASSERT_LT(RedisConnection::Clock::now(), until) << "waited for redis-server: " << connection.error().message;
        ASSERT_EQ(waitpid(process_, nullptr, WNOHANG), 0) << "redis-server has ended; see " << folder_ << "/log";
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
}

void LocalRedis::kill() {
    if (process_ < 0) return;
    ::kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
    process_ = -1;
}

void LocalRedis::pause() {
    ::kill(process_, SIGSTOP);
}

void LocalRedis::resume() {
    ::kill(process_, SIGCONT);
}

}  // namespace ccdt::server::test
