// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <stop_token>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "core/base/result.h"
#include "server/http/hosts.h"
#include "server/jobs/job_store.h"

namespace ccdt::server {

/// Secrets that sign webhooks, as bytes.
using WebhookKeys = std::vector<std::string>;

/// Reads a file with lines `name:whsec_...`, as KeyRing does. The text after `whsec_` is base64 of 24 to 64 bytes.
/// Errors: those of KeyRing::read(); Malformed if a key has another form. The message names the file, not the key.
Result<WebhookKeys> read_webhook_keys(const std::string& file);

/// Returns the value of the header webhook-signature of Standard Webhooks: a signature for each key.
std::string webhook_signature(const WebhookKeys& keys, std::string_view id, std::string_view timestamp,
                              std::string_view body);

/// Sends the webhooks of finished jobs.
///
/// Claims webhooks from the store. If servers share the store, one of them sends each webhook, usually the one that ran
/// the job. If it is lost while it sends, another one repeats the attempt, so a webhook may arrive more than once, with
/// the same webhook-id. An attempt fails unless the status of the answer is 2xx. Failed attempts are repeated after
/// increasing pauses, but not after the status 410. Thread-safe.
class Webhooks {
public:
    struct Settings {
        TargetHosts hosts;
        std::string key_file;
        std::chrono::milliseconds timeout{10'000};     ///< limit of an attempt
        std::chrono::milliseconds first_pause{5'000};  ///< after the first attempt; each later pause is 8 times longer
        int max_attempts = 5;
    };

    /// Numbers of attempts since the start.
    struct Counts {
        std::uint64_t sent = 0;
        std::uint64_t failed = 0;
    };

    using Warn = std::function<void(const std::string&)>;

    /// Starts to send. `store` must outlive this object.
    /// Errors: those of read_webhook_keys().
    static Result<std::unique_ptr<Webhooks>> start(Settings settings, JobStore& store, Warn warn);

    /// Reads the key file again. An error leaves the present keys in use.
    Result<void> read_keys();

    /// Tells the threads that a job has ended. Otherwise, they look for webhooks every two seconds.
    void wake();

    Counts counts() const { return {sent_, failed_}; }

private:
    Webhooks(Settings settings, JobStore& store, Warn warn, WebhookKeys keys);

    void send_all(const std::stop_token& stop);
    void send(const JobStore::Webhook& webhook, const std::stop_token& stop);
    Result<int> attempt(const Job& job, const std::stop_token& stop);

    const Settings settings_;
    JobStore& store_;
    const Warn warn_;
    std::atomic<std::uint64_t> sent_ = 0;
    std::atomic<std::uint64_t> failed_ = 0;

    std::mutex mutex_;  ///< guards the members below
    std::condition_variable_any woken_;
    std::uint64_t wakes_ = 0;
    WebhookKeys keys_;

    std::vector<std::jthread> threads_;  ///< last, because the threads use all other members
};

}  // namespace ccdt::server
