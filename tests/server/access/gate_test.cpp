#include "server/access/gate.h"

#include <gtest/gtest.h>

#include <unistd.h>

#include <filesystem>
#include <fstream>

namespace ccdt::server {
namespace {

const std::string kKey = "0123456789abcdef";

class GateTest : public testing::Test {
protected:
    ~GateTest() override { std::filesystem::remove(file_); }

    void write(const std::string& text) const { std::ofstream(file_) << text; }

    static Request request(const std::string& key, const std::string& line = "GET /x") {
        const std::string header = key.empty() ? "" : "Authorization: Bearer " + key + "\r\n";
        return *parse_head(line + " HTTP/1.1\r\n" + header + "\r\n");
    }

    const std::string file_ = testing::TempDir() + "ccdt_keys_" + std::to_string(::getpid());
    std::string keys_ = file_;  ///< the file that the gate is told of
    RateLimiter::Rate rate_;
};

TEST_F(GateTest, AsksForAKeyIfThereAreAny) {
    write("alice:" + kKey);
    Gate gate(keys_, rate_);
    ASSERT_TRUE(gate.read_keys());
    EXPECT_EQ(gate.check(request(kKey), "a").key, "alice");
    EXPECT_TRUE(gate.check(request(kKey), "a").admission);
    EXPECT_EQ(gate.check(request(""), "a").admission.error().status, 401);
    EXPECT_EQ(gate.check(request(kKey + "x"), "a").admission.error().headers.front().name, "WWW-Authenticate");
    for (const char* line : {"GET /x", "OPTIONS /halftone", "OPTIONS *"})
        EXPECT_FALSE(gate.check(request("", line), "a").admission) << line;
}

TEST_F(GateTest, LetsPassWhatIsFree) {
    write("alice:" + kKey);
    rate_ = {.per_second = 0.001, .burst = 1};
    Gate gate(keys_, rate_);
    ASSERT_TRUE(gate.read_keys());
    for (int i = 0; i < 5; ++i) {
        const auto verdict = gate.check(request(kKey), "a", true);
        EXPECT_TRUE(verdict.admission);
        EXPECT_EQ(verdict.client, "a");
        EXPECT_EQ(verdict.key, "");
    }
}

TEST_F(GateTest, LetsPreflightsPass) {
    write("alice:" + kKey);
    Gate gate(keys_, rate_);
    ASSERT_TRUE(gate.read_keys());
    const auto passes = [&](const std::string& method, const std::string& headers) {
        return gate.check(*parse_head(method + " /halftone HTTP/1.1\r\n" + headers + "\r\n"), "a")
            .admission.has_value();
    };
    const std::string origin = "Origin: https://example.org\r\n", asked = "Access-Control-Request-Method: POST\r\n";
    EXPECT_TRUE(passes("OPTIONS", origin + asked));
    EXPECT_FALSE(passes("OPTIONS", origin));
    EXPECT_FALSE(passes("OPTIONS", asked));
    EXPECT_FALSE(passes("POST", origin + asked));
}

TEST_F(GateTest, CountsPreflightsByAddress) {
    write("alice:" + kKey);
    rate_ = {.per_second = 0.001, .burst = 2};
    Gate gate(keys_, rate_);
    ASSERT_TRUE(gate.read_keys());
    const auto status = [&](const std::string& line, const std::string& address) {
        const auto asked = "Origin: https://example.org\r\nAccess-Control-Request-Method: POST\r\n";
        const auto admission = gate.check(*parse_head(line + " HTTP/1.1\r\n" + asked + "\r\n"), address).admission;
        return admission ? 200 : admission.error().status;
    };
    for (const int expected : {200, 200, 429, 429}) EXPECT_EQ(status("OPTIONS /halftone", "a"), expected);
    EXPECT_EQ(status("OPTIONS /halftone", "b"), 200);
    EXPECT_TRUE(gate.check(request(kKey), "a").admission) << "a key has its own count";
}

TEST_F(GateTest, LetsEverybodyPassWithoutAFile) {
    keys_.clear();
    Gate gate(keys_, rate_);
    EXPECT_TRUE(gate.read_keys());
    EXPECT_TRUE(gate.check(request(""), "a").admission);
    EXPECT_EQ(gate.check(request(kKey), "a").key, "");
}

TEST_F(GateTest, KeepsItsKeysIfTheFileIsBroken) {
    write("alice:" + kKey);
    Gate gate(keys_, rate_);
    ASSERT_TRUE(gate.read_keys());
    write("nonsense");
    EXPECT_FALSE(gate.read_keys());
    EXPECT_EQ(gate.check(request(kKey), "a").key, "alice");
    write("bob:" + kKey);
    EXPECT_TRUE(gate.read_keys());
    EXPECT_EQ(gate.check(request(kKey), "a").key, "bob");
}

TEST_F(GateTest, CountsByKeyAndElseByAddress) {
    write("alice:" + kKey);
    rate_ = {.per_second = 0.001, .burst = 1};
    Gate gate(keys_, rate_);
    ASSERT_TRUE(gate.read_keys());
    EXPECT_TRUE(gate.check(request(kKey), "a").admission);
    EXPECT_EQ(gate.check(request(kKey), "b").admission.error().status, 429);
    EXPECT_EQ(gate.check(request("x"), "a").admission.error().status, 401);
    EXPECT_EQ(gate.check(request("y"), "a").admission.error().status, 429);
    EXPECT_EQ(gate.check(request("y"), "").admission.error().status, 401) << "nothing to count by";
}

}  // namespace
}  // namespace ccdt::server
