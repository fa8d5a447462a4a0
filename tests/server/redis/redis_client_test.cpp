// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/redis/redis_client.h"

#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "server/redis/redis_subscription.h"
#include "tests/server/redis/local_redis.h"
#include "tests/server/waiting.h"

namespace ccdt::server {
namespace {

using test::LocalRedis;

class RedisClientTest : public testing::Test {
protected:
    std::string get(std::string_view key) {
        const auto reply = client_.run(RedisCommand{"GET", key});
        EXPECT_TRUE(reply) << reply.error().message;
        return reply ? reply->text : "";
    }

    /// Waits until Redis can be reached again.
    void wait_until_back() {
        ASSERT_TRUE(
            test::wait_until("a reply of Redis", [&] { return client_.run(RedisCommand{"PING"}).has_value(); }));
    }

    LocalRedis redis_;
    RedisClient client_{redis_.address(), std::chrono::milliseconds(500)};
};

TEST_F(RedisClientTest, StoresAnyBytes) {
    std::string bytes(3'000'000, '\0');
    for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<char>(i * i / 3);
    ASSERT_TRUE(client_.run(RedisCommand{"SET", "k", bytes}));
    EXPECT_EQ(get("k"), bytes);
}

TEST_F(RedisClientTest, ReadsRepliesOfEveryKind) {
    const std::vector<RedisCommand> commands{
        {"INCR", "n"}, {"GET", "none"}, {"RPUSH", "l", "a", "b"}, {"LRANGE", "l", "0", "-1"}};
    const auto replies = client_.run(commands);
    ASSERT_TRUE(replies);
    EXPECT_EQ(replies->at(0).number, 1);
    EXPECT_EQ(replies->at(1).kind, RedisReply::Kind::Nothing);
    EXPECT_EQ(replies->at(3).items.at(1).text, "b");
    const auto failed = client_.run(RedisCommand{"INCR", "l"});
    ASSERT_FALSE(failed);
    EXPECT_EQ(failed.error().code, ErrorCode::Unusable) << "the key has a list";
    EXPECT_EQ(client_.counts().calls, 2u);
    EXPECT_EQ(client_.counts().failures, 1u);
}

TEST_F(RedisClientTest, LoadsUnknownScripts) {
    const RedisScript script("no-writes",
                             {"local function both(a, b) return a .. b end", "return both(KEYS[1], ARGV[1])"});
    EXPECT_EQ(client_.run(script, "a", {"b"})->text, "ab");
    EXPECT_EQ(client_.run(script, "c", {"d"})->text, "cd");
    ASSERT_TRUE(client_.run(RedisCommand{"SCRIPT", "FLUSH"}));
    EXPECT_EQ(client_.run(script, "e", {"f"})->text, "ef");
}

TEST_F(RedisClientTest, Reconnects) {
    ASSERT_TRUE(client_.run(RedisCommand{"SET", "k", "v"}));
    redis_.kill();
    const auto away = client_.run(RedisCommand{"PING"});
    ASSERT_FALSE(away);
    EXPECT_EQ(away.error().code, ErrorCode::Stopped);
    redis_.start();
    wait_until_back();
    redis_.kill();
    redis_.start();
    EXPECT_TRUE(client_.run(RedisCommand{"PING"})) << "a lost idle connection must be replaced at once";
}

TEST_F(RedisClientTest, RespectsItsDeadline) {
    ASSERT_TRUE(client_.run(RedisCommand{"PING"}));
    redis_.pause();
    const auto late = client_.run(RedisCommand{"PING"});
    ASSERT_FALSE(late);
    EXPECT_EQ(late.error().code, ErrorCode::Stopped);
    redis_.resume();
    wait_until_back();
}

/// A server that replies to any request with `answer`, then repeats `rest` until the client disconnects.
class NoRedis {
public:
    NoRedis(std::string answer, std::string rest) : answer_(std::move(answer)), rest_(std::move(rest)) {
        sockaddr_in position{};
        position.sin_family = AF_INET;
        position.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
        socklen_t size = sizeof(position);
        EXPECT_EQ(bind(listener_, reinterpret_cast<sockaddr*>(&position), size), 0);
        EXPECT_EQ(listen(listener_, 5), 0);
        EXPECT_EQ(getsockname(listener_, reinterpret_cast<sockaddr*>(&position), &size), 0);
        address_.host = "127.0.0.1";
        address_.port = std::to_string(ntohs(position.sin_port));
        thread_ = std::jthread([this] {
            const int client = accept(listener_, nullptr, nullptr);
            char asked[1000];
            if (recv(client, asked, sizeof(asked), 0) > 0) send(client, answer_.data(), answer_.size(), MSG_NOSIGNAL);
            EXPECT_TRUE(test::wait_until("the client to disconnect", [&] {
                return rest_.empty() || send(client, rest_.data(), rest_.size(), MSG_NOSIGNAL) <= 0;
            }));
            close(client);
        });
    }
    ~NoRedis() {
        thread_.join();
        close(listener_);
    }

    const RedisAddress& address() const { return address_; }

private:
    const int listener_ = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    const std::string answer_;
    const std::string rest_;
    RedisAddress address_;
    std::jthread thread_;
};

TEST(RedisClient, RespectsItsDeadlineDuringAnEndlessReply) {
    const NoRedis slow("+OK\r\n$500000000\r\n", "a few bytes");
    RedisClient client(slow.address(), std::chrono::milliseconds(100));
    const auto late = client.run(RedisCommand{"PING"});
    ASSERT_FALSE(late);
    EXPECT_EQ(late.error().code, ErrorCode::Stopped);
}

TEST(RedisClient, DetectsAServerThatIsNotRedis) {
    const NoRedis other("HTTP/1.1 400 Bad Request\r\n\r\n", "");
    RedisClient client(other.address());
    const auto failed = client.run(RedisCommand{"PING"});
    ASSERT_FALSE(failed);
    EXPECT_NE(failed.error().message.find("malformed reply"), std::string::npos) << failed.error().message;
}

TEST_F(RedisClientTest, ReportsThatTheMemoryIsFull) {
    ASSERT_TRUE(client_.run(RedisCommand{"CONFIG", "SET", "maxmemory", "1"}));
    const auto full = client_.run(RedisCommand{"SET", "k", "v"});
    ASSERT_FALSE(full);
    EXPECT_EQ(full.error().code, ErrorCode::LimitExceeded);
}

TEST_F(RedisClientTest, IsThreadSafe) {
    {
        std::vector<std::jthread> threads;
        for (int thread = 0; thread < 40; ++thread)
            threads.emplace_back([this] {
                for (int i = 0; i < 50; ++i) EXPECT_TRUE(client_.run(RedisCommand{"INCR", "n"}));
            });
    }
    EXPECT_EQ(get("n"), "2000");
}

TEST(RedisClient, AuthenticatesWithUserAndPassword) {
    const LocalRedis redis({"--requirepass", "secret"});
    auto address = redis.address();
    EXPECT_FALSE(RedisClient(address).run(RedisCommand{"PING"}));
    address.password = "wrong";
    EXPECT_FALSE(RedisClient(address).run(RedisCommand{"PING"}));
    address.password = "secret";
    EXPECT_TRUE(RedisClient(address).run(RedisCommand{"PING"}));
    address.user = "default";
    address.database = 3;
    RedisClient client(address);
    ASSERT_TRUE(client.run(RedisCommand{"SET", "k", "v"}));
    address.database = 0;
    EXPECT_EQ(RedisClient(address).run(RedisCommand{"GET", "k"})->kind, RedisReply::Kind::Nothing);
}

TEST(RedisSubscription, Resubscribes) {
    LocalRedis redis;
    std::mutex mutex;
    std::condition_variable more;
    std::vector<std::string> told;
    const auto add = [&](std::string what) {
        const std::lock_guard lock(mutex);
        told.push_back(std::move(what));
        more.notify_all();
    };
    const auto wait_for = [&](const std::string& what, std::ptrdiff_t times) {
        std::unique_lock lock(mutex);
        const auto is_told = [&] { return std::ranges::count(told, what) >= times; };
        EXPECT_TRUE(more.wait_for(lock, test::kPatience, is_told)) << "waited for the event '" << what << "'";
    };
    const RedisSubscription subscription(redis.address(), "news",
                                         {.message = [&](std::string_view text) { add(std::string(text)); },
                                          .begun = [&] { add("begun"); },
                                          .ended = [&](const Error&) { add("ended"); }});
    wait_for("begun", 1);
    ASSERT_TRUE(RedisClient(redis.address()).run(RedisCommand{"PUBLISH", "news", "a b"}));
    wait_for("a b", 1);
    redis.kill();
    wait_for("ended", 1);
    redis.start();
    wait_for("begun", 2);
    ASSERT_TRUE(RedisClient(redis.address()).run(RedisCommand{"PUBLISH", "news", "c"}));
    wait_for("c", 1);
    EXPECT_EQ(told, (std::vector<std::string>{"begun", "a b", "ended", "begun", "c"}));
}

}  // namespace
}  // namespace ccdt::server
