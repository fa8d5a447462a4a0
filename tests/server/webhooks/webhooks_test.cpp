// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/webhooks/webhooks.h"

#include <filesystem>
#include <fstream>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>
#include <sys/socket.h>

#include "server/http/http_client.h"
#include "server/http/sockets.h"
#include "server/jobs/sqlite_job_store.h"
#include "tests/server/jobs/example_jobs.h"
#include "tests/server/waiting.h"

namespace ccdt::server {
namespace {

/// A host that receives webhooks, and answers them with the given lines, the last of which is repeated.
class Receiver {
public:
    explicit Receiver(std::vector<std::string> answers)
        : answers_(std::move(answers)), thread_([this](const std::stop_token& stop) { receive(stop); }) {}

    std::string url() const { return "http://127.0.0.1:" + std::to_string(socket_.port()) + "/hook"; }

    std::vector<std::string> requests() const {
        const std::lock_guard lock(mutex_);
        return requests_;
    }

private:
    void receive(const std::stop_token& stop) {
        while (!stop.stop_requested()) {
            socket_.wait(std::chrono::milliseconds(10));
            const UniqueFd client(accept(socket_.descriptor(), nullptr, nullptr));
            if (!client) continue;
            std::string request(64'000, '\0');
            std::size_t size = 0;
            while (!request.substr(0, size).ends_with("}")) {
                const auto more = recv(client.get(), request.data() + size, request.size() - size, 0);
                if (more <= 0) break;
                size += static_cast<std::size_t>(more);
            }
            const std::lock_guard lock(mutex_);
            requests_.push_back(request.substr(0, size));
            const auto& answer = answers_[std::min(requests_.size(), answers_.size()) - 1];
            const std::string text = "HTTP/1.1 " + answer + "\r\nContent-Length: 0\r\n\r\n";
            send(client.get(), text.data(), text.size(), MSG_NOSIGNAL);
        }
    }

    const ListeningSocket socket_ = *ListeningSocket::open("127.0.0.1", 0);
    const std::vector<std::string> answers_;
    mutable std::mutex mutex_;  ///< guards the member below
    std::vector<std::string> requests_;
    std::jthread thread_;
};

std::string line_of(const std::string& request, const std::string& name) {
    const auto start = request.find(name + ": ");
    return start == std::string::npos ? "" : request.substr(start, request.find("\r\n", start) - start);
}

class WebhooksTest : public testing::Test {
protected:
    WebhooksTest() : file_((std::filesystem::path(testing::TempDir()) / "webhook-keys-XXXXXX").string()) {
        const UniqueFd created(mkstemp(file_.data()));
        write("main:whsec_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw");
    }
    ~WebhooksTest() override { std::filesystem::remove(file_); }

    void write(const std::string& text) const { std::ofstream(file_) << text; }

    /// Finishes a job with a webhook, and sends the webhook until it is settled.
    /// @returns  warnings
    std::vector<std::string> send(const std::string& url, const std::string& hosts = "127.0.0.1") {
        const auto store = *SqliteJobStore::open("");
        Job job = test::job_named("a");
        job.callback = url;
        test::add(*store, job);
        EXPECT_TRUE(*store->finish(test::succeeded(**store->claim(1000), "result"), "result"));
        std::mutex mutex;
        std::vector<std::string> warnings;
        const auto webhooks = *Webhooks::start({.hosts = *TargetHosts::parse(hosts),
                                                .key_file = file_,
                                                .first_pause = std::chrono::milliseconds(1),
                                                .max_attempts = 3},
                                               *store, [&](const std::string& warning) {
                                                   const std::lock_guard lock(mutex);
                                                   warnings.push_back(warning);
                                               });
        EXPECT_TRUE(test::wait_until("the webhook to be settled", [&] {
            webhooks->wake();
            return (*store->find("a"))->callback.empty();
        }));
        counts_ = webhooks->counts();
        return warnings;
    }

    std::string file_;
    Webhooks::Counts counts_;
};

TEST_F(WebhooksTest, SignsAsStandardWebhooksDo) {
    // The example of the specification and of its libraries.
    EXPECT_EQ(webhook_signature(*read_webhook_keys(file_), "msg_p5jXN8AQM9LWM0D4loKWxJek", "1614265330",
                                R"({"test": 2432232314})"),
              "v1,g0hM9SsE+OTPJTGt/tmIKtSyZlE3uFJELVlNIOLJ1OE=");
    write("old:whsec_MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw\nnew:whsec_C2FVsBQIhrscChlQIMV+b5sSYspob7oD\n");
    const auto both = webhook_signature(*read_webhook_keys(file_), "a", "1", "{}");
    EXPECT_EQ(both.size(), 2 * std::string("v1,").size() + 1 + 2 * 44);
    EXPECT_EQ(both.substr(47, 4), " v1,");
}

TEST_F(WebhooksTest, RefusesKeysOfOtherForms) {
    for (const char* key :
         {"MfKQ9r8GKYqrTwjUPD8ILPZIo2LaLaSw", "whsec_MfKQ9r8GKYqrTwjU", "whsec_!!KQ9r8GKYqrTwjUPD8ILPZIo2"}) {
        write(std::string("main:") + key);
        const auto keys = read_webhook_keys(file_);
        ASSERT_FALSE(keys) << key;
        EXPECT_NE(keys.error().message.find("whsec_"), std::string::npos) << keys.error().message;
        EXPECT_EQ(keys.error().message.find(key), std::string::npos) << keys.error().message;
    }
}

TEST_F(WebhooksTest, SendsTheJob) {
    const Receiver receiver({"204 No Content"});
    EXPECT_EQ(send(receiver.url()), std::vector<std::string>());
    ASSERT_EQ(receiver.requests().size(), 1u);
    const std::string request = receiver.requests()[0];
    const std::string body = request.substr(request.find("\r\n\r\n") + 4);
    EXPECT_EQ(request.substr(0, request.find("\r\n")), "POST /hook HTTP/1.1");
    EXPECT_NE(body.find(R"("status":"succeeded")"), std::string::npos) << body;
    EXPECT_EQ(line_of(request, "webhook-id"), "webhook-id: a");
    const std::string time = line_of(request, "webhook-timestamp").substr(19);
    EXPECT_EQ(line_of(request, "webhook-signature"),
              "webhook-signature: " + webhook_signature(*read_webhook_keys(file_), "a", time, body));
    EXPECT_EQ(counts_.sent, 1u);
}

TEST_F(WebhooksTest, RepeatsFailedAttempts) {
    const Receiver receiver({"500 Failed", "302 Found\r\nLocation: /", "200 OK"});
    EXPECT_EQ(send(receiver.url()).size(), 2u);
    ASSERT_EQ(receiver.requests().size(), 3u);
    EXPECT_EQ(line_of(receiver.requests()[0], "webhook-id"), line_of(receiver.requests()[2], "webhook-id"));
    EXPECT_EQ(counts_.sent, 1u);
    EXPECT_EQ(counts_.failed, 2u);
}

TEST_F(WebhooksTest, EndsAfterTheLastAttempt) {
    const Receiver receiver({"500 Failed"});
    const auto warnings = send(receiver.url());
    EXPECT_EQ(receiver.requests().size(), 3u);
    EXPECT_EQ(warnings.back(),
              "attempt 3 of 3 to send the webhook of job a failed, and was the last one: the status is 500");
}

TEST_F(WebhooksTest, EndsIfTheUrlIsGone) {
    const Receiver receiver({"410 Gone"});
    EXPECT_EQ(send(receiver.url()).size(), 1u);
    EXPECT_EQ(receiver.requests().size(), 1u);
}

TEST_F(WebhooksTest, ConnectsToPrivateAddressesOnlyIfListed) {
    const Receiver receiver({"200 OK"});
    const std::string url = "http://localhost" + receiver.url().substr(receiver.url().rfind(':'));
    const auto warnings = send(url, "localhost");
    EXPECT_NE(warnings.back().find(" is not public and not permitted"), std::string::npos) << warnings.back();
    EXPECT_EQ(receiver.requests().size(), 0u);
    EXPECT_EQ(send(url, "localhost,127.0.0.0/8"), std::vector<std::string>());
    EXPECT_EQ(receiver.requests().size(), 1u);
}

TEST(HttpClient, ChecksTargets) {
    const auto hosts = *TargetHosts::parse("hooks.example,127.0.0.1,::1,10.0.0.0/8");
    for (const char* url :
         {"https://hooks.example", "http://HOOKS.example:8080/a?b=c", "https://[::1]/", "http://127.1/"})
        EXPECT_TRUE(check_target(url, hosts)) << url;
    for (const char* url :
         {"", "hooks.example", "/a", "ftp://hooks.example", "file:///etc/passwd", "https://example", "https://10.0.0.1",
          "https://a@hooks.example", "https://hooks.example@evil.example", "https://hooks.example#a",
          "https://hooks.example.", "https://hooks.example\\@evil.example/", "https://hooks.example/\r\na", "https://"})
        EXPECT_FALSE(check_target(url, hosts)) << url;
    EXPECT_TRUE(check_target("https://hooks.example/" + std::string(1002, 'a'), hosts));
    EXPECT_FALSE(check_target("https://hooks.example/" + std::string(1003, 'a'), hosts));
    EXPECT_FALSE(check_target("https://hooks.example", {}));
}

}  // namespace
}  // namespace ccdt::server
