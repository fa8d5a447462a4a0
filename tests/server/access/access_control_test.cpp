// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/access/access_control.h"

#include <gtest/gtest.h>

#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "server/requests/digest.h"

namespace ccdt::server {
namespace {

const std::string kKey = "0123456789abcdef";

class AccessControlTest : public testing::Test {
protected:
    ~AccessControlTest() override { std::filesystem::remove(file_); }

    void write(const std::string& text) const { std::ofstream(file_) << text; }

    static Request request(const std::string& key, const std::string& line = "GET /x") {
        const std::string header = key.empty() ? "" : "Authorization: Bearer " + key + "\r\n";
        return *parse_head(line + " HTTP/1.1\r\n" + header + "\r\n");
    }

    const std::string file_ = testing::TempDir() + "ccdt_keys_" + std::to_string(::getpid());
    std::string keys_ = file_;  ///< name of the key file, for AccessControl
    RateLimiter::Rate rate_;
};

TEST_F(AccessControlTest, RequiresAKeyIfKeysAreConfigured) {
    write("alice:" + kKey);
    AccessControl access_control(keys_, rate_);
    ASSERT_TRUE(access_control.read_keys());
    EXPECT_EQ(access_control.check(request(kKey), "a").key, "alice");
    EXPECT_TRUE(access_control.check(request(kKey), "a").admission);
    EXPECT_EQ(access_control.check(request(""), "a").admission.error().status, 401);
    EXPECT_EQ(access_control.check(request(kKey + "x"), "a").admission.error().headers.front().name,
              "WWW-Authenticate");
    for (const char* line : {"GET /x", "OPTIONS /halftone", "OPTIONS *"})
        EXPECT_FALSE(access_control.check(request("", line), "a").admission) << line;
}

TEST_F(AccessControlTest, AdmitsRequestsThatNeedNoCredential) {
    write("alice:" + kKey);
    rate_ = {.per_second = 0.001, .burst = 1};
    AccessControl access_control(keys_, rate_);
    ASSERT_TRUE(access_control.read_keys());
    for (int i = 0; i < 5; ++i) {
        const auto verdict = access_control.check(request(kKey), "a", AccessControl::Credential::None);
        EXPECT_TRUE(verdict.admission);
        EXPECT_EQ(verdict.client, "a");
        EXPECT_EQ(verdict.key, "");
    }
}

TEST_F(AccessControlTest, AdmitsPreflightsWithoutAKey) {
    write("alice:" + kKey);
    AccessControl access_control(keys_, rate_);
    ASSERT_TRUE(access_control.read_keys());
    const auto passes = [&](const std::string& method, const std::string& headers) {
        return access_control.check(*parse_head(method + " /halftone HTTP/1.1\r\n" + headers + "\r\n"), "a")
            .admission.has_value();
    };
    const std::string origin = "Origin: https://example.org\r\n", header = "Access-Control-Request-Method: POST\r\n";
    EXPECT_TRUE(passes("OPTIONS", origin + header));
    EXPECT_FALSE(passes("OPTIONS", origin));
    EXPECT_FALSE(passes("OPTIONS", header));
    EXPECT_FALSE(passes("POST", origin + header));
}

TEST_F(AccessControlTest, LimitsTheRateOfPreflightsByAddress) {
    write("alice:" + kKey);
    rate_ = {.per_second = 0.001, .burst = 2};
    AccessControl access_control(keys_, rate_);
    ASSERT_TRUE(access_control.read_keys());
    const auto status = [&](const std::string& line, const std::string& address) {
        const auto header = "Origin: https://example.org\r\nAccess-Control-Request-Method: POST\r\n";
        const auto admission =
            access_control.check(*parse_head(line + " HTTP/1.1\r\n" + header + "\r\n"), address).admission;
        return admission ? 200 : admission.error().status;
    };
    for (const int expected : {200, 200, 429, 429}) EXPECT_EQ(status("OPTIONS /halftone", "a"), expected);
    EXPECT_EQ(status("OPTIONS /halftone", "b"), 200);
    EXPECT_TRUE(access_control.check(request(kKey), "a").admission) << "a key has its own count";
}

TEST_F(AccessControlTest, AdmitsEverybodyWithoutAKeyFile) {
    keys_.clear();
    AccessControl access_control(keys_, rate_);
    EXPECT_TRUE(access_control.read_keys());
    EXPECT_TRUE(access_control.check(request(""), "a").admission);
    EXPECT_EQ(access_control.check(request(kKey), "a").key, "");
}

TEST_F(AccessControlTest, KeepsItsKeysIfTheFileIsBroken) {
    write("alice:" + kKey);
    AccessControl access_control(keys_, rate_);
    ASSERT_TRUE(access_control.read_keys());
    write("nonsense");
    EXPECT_FALSE(access_control.read_keys());
    EXPECT_EQ(access_control.check(request(kKey), "a").key, "alice");
    write("bob:" + kKey);
    EXPECT_TRUE(access_control.read_keys());
    EXPECT_EQ(access_control.check(request(kKey), "a").key, "bob");
}

TEST_F(AccessControlTest, LimitsTheRateByKeyOrAddress) {
    write("alice:" + kKey);
    rate_ = {.per_second = 0.001, .burst = 1};
    AccessControl access_control(keys_, rate_);
    ASSERT_TRUE(access_control.read_keys());
    EXPECT_TRUE(access_control.check(request(kKey), "a").admission);
    EXPECT_EQ(access_control.check(request(kKey), "b").admission.error().status, 429);
    EXPECT_EQ(access_control.check(request("x"), "a").admission.error().status, 401);
    EXPECT_EQ(access_control.check(request("y"), "a").admission.error().status, 429);
    EXPECT_EQ(access_control.check(request("y"), "").admission.error().status, 401) << "nothing to count by";
}

const std::string kSigningKey = "0123456789abcdef0123456789abcdef";

/// Returns a request for a URL that is signed with `key`.
Request signed_request(const std::string& key, const std::string& text, const std::string& method = "GET") {
    return *parse_head(method + ' ' + text + "&signature=" + sign(key, text) + " HTTP/1.1\r\n\r\n");
}

TEST_F(AccessControlTest, AcceptsASignatureInsteadOfAKey) {
    write("alice:" + kKey);
    AccessControl access_control(keys_, rate_, nullptr, {{}, kSigningKey});
    ASSERT_TRUE(access_control.read_keys());
    const auto check = [&](const Request& request) {
        return access_control.check(request, "a", AccessControl::Credential::Signature);
    };
    const auto verdict = check(signed_request(kSigningKey, "/halftone/x?sites=5"));
    EXPECT_TRUE(verdict.admission);
    EXPECT_EQ(verdict.signer, "CCDT_SIGNING_KEY");
    EXPECT_EQ(verdict.key, "") << "what is kept for visitors is kept for all of them";
    EXPECT_EQ(verdict.client, "a");
    EXPECT_EQ(check(request(kKey, "GET /halftone/x")).admission.error().status, 403) << "an API key is no signature";
    EXPECT_EQ(check(signed_request(kKey, "/halftone/x?sites=5")).admission.error().status, 403);
    const auto elsewhere = signed_request(kSigningKey, "/metrics?a=b");
    EXPECT_EQ(access_control.check(elsewhere, "a", AccessControl::Credential::Key).admission.error().status, 401);
}

TEST_F(AccessControlTest, RequiresAKeyIfSigningIsNotConfigured) {
    write("alice:" + kKey);
    AccessControl access_control(keys_, rate_);
    ASSERT_TRUE(access_control.read_keys());
    EXPECT_EQ(access_control.check(request(""), "a", AccessControl::Credential::Signature).admission.error().status,
              401);
    EXPECT_EQ(access_control.check(request(kKey), "a", AccessControl::Credential::Signature).key, "alice");
}

TEST_F(AccessControlTest, LimitsTheRateOfSignedUrlsByAddress) {
    rate_ = {.per_second = 0.001, .burst = 1};
    AccessControl access_control({}, rate_, nullptr, {{}, kSigningKey});
    ASSERT_TRUE(access_control.read_keys());
    const auto status = [&](const std::string& key, const std::string& address) {
        const auto admission =
            access_control.check(signed_request(key, "/halftone/x?a=b"), address, AccessControl::Credential::Signature)
                .admission;
        return admission ? 200 : admission.error().status;
    };
    EXPECT_EQ(status(kSigningKey, "a"), 200);
    EXPECT_EQ(status(kSigningKey, "a"), 429);
    EXPECT_EQ(status(kSigningKey, "b"), 200);
    EXPECT_EQ(status(kKey, "c"), 403);
    EXPECT_EQ(status(kKey, "c"), 429) << "signatures cannot be guessed fast";
}

TEST_F(AccessControlTest, ReloadsSigningKeys) {
    AccessControl access_control({}, rate_, nullptr, {file_, {}});
    const std::string second = kSigningKey + "B";
    const auto signer = [&](const std::string& key) {
        return access_control.check(signed_request(key, "/halftone/x?a=b"), "a", AccessControl::Credential::Signature)
            .signer;
    };
    write("old:" + kSigningKey + "\nnew:" + second);
    ASSERT_TRUE(access_control.read_keys());
    EXPECT_EQ(signer(kSigningKey), "old");
    EXPECT_EQ(signer(second), "new");
    write("new:" + second);
    ASSERT_TRUE(access_control.read_keys());
    EXPECT_EQ(signer(kSigningKey), "");
    write("new:" + kKey);
    const auto read = access_control.read_keys();
    ASSERT_FALSE(read) << "too short to sign with";
    EXPECT_NE(read.error().message.find("32 to 256"), std::string::npos) << read.error().message;
    EXPECT_EQ(signer(second), "new");
}

TEST_F(AccessControlTest, ReportsTheVariableOfAnInvalidSigningKeyButNotTheKey) {
    for (const std::string& key : {kKey, kSigningKey + " ", kSigningKey + "\nb:" + kSigningKey}) {
        const auto read = AccessControl({}, rate_, nullptr, {{}, key}).read_keys();
        ASSERT_FALSE(read);
        EXPECT_TRUE(read.error().message.starts_with("CCDT_SIGNING_KEY: ")) << read.error().message;
        EXPECT_EQ(read.error().message.find(kKey), std::string::npos);
    }
}

}  // namespace
}  // namespace ccdt::server
