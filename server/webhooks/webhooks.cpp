// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/webhooks/webhooks.h"

#include <algorithm>
#include <exception>
#include <optional>
#include <utility>

#include "api/image/embedded_image.h"
#include "server/access/key_ring.h"
#include "server/http/http_client.h"
#include "server/requests/digest.h"

namespace ccdt::server {
namespace {

/// Number of webhooks that are sent at the same time, so that slow hosts do not delay the others.
constexpr int kThreads = 4;

constexpr std::chrono::seconds kPollInterval{2};

constexpr int kGone = 410;

bool is_success(const Result<int>& status) {
    return status && *status >= 200 && *status < 300;
}

}  // namespace

Result<WebhookKeys> read_webhook_keys(const std::string& file) {
    constexpr std::string_view kPrefix = "whsec_";
    const auto ring = KeyRing::read(file);
    if (!ring) return tl::unexpected(ring.error());
    WebhookKeys keys;
    for (const std::string& text : ring->keys()) {
        const auto key = api::decode_base64(text.substr(std::min(kPrefix.size(), text.size())));
        if (!text.starts_with(kPrefix) || !key || key->size() < 24 || key->size() > 64)
            return failure(ErrorCode::Malformed, file + ": a key must be whsec_ followed by base64 of 24 to 64 bytes");
        keys.push_back(*key);
    }
    return keys;
}

std::string webhook_signature(const WebhookKeys& keys, std::string_view id, std::string_view timestamp,
                              std::string_view body) {
    const std::string text = std::string(id) + '.' + std::string(timestamp) + '.' + std::string(body);
    std::string signatures;
    for (const std::string& key : keys) signatures += (signatures.empty() ? "v1," : " v1,") + sign_in_base64(key, text);
    return signatures;
}

Result<std::unique_ptr<Webhooks>> Webhooks::start(Settings settings, JobStore& store, Warn warn) {
    auto keys = read_webhook_keys(settings.key_file);
    if (!keys) return tl::unexpected(keys.error());
    return std::unique_ptr<Webhooks>(new Webhooks(std::move(settings), store, std::move(warn), *std::move(keys)));
}

Webhooks::Webhooks(Settings settings, JobStore& store, Warn warn, WebhookKeys keys)
    : settings_(std::move(settings)), store_(store), warn_(std::move(warn)), keys_(std::move(keys)) {
    for (int i = 0; i < kThreads; ++i) threads_.emplace_back([this](const std::stop_token& stop) { send_all(stop); });
}

Result<void> Webhooks::read_keys() {
    return read_webhook_keys(settings_.key_file).map([this](WebhookKeys&& keys) {
        const std::lock_guard lock(mutex_);
        keys_ = std::move(keys);
    });
}

void Webhooks::wake() {
    const std::lock_guard lock(mutex_);
    ++wakes_;
    woken_.notify_one();
}

void Webhooks::send_all(const std::stop_token& stop) {
    for (std::uint64_t seen = 0; !stop.stop_requested();) {
        // The lease is longer than an attempt, after which the webhook is settled.
        const auto webhook = store_.claim_webhook(3 * settings_.timeout);
        if (webhook && *webhook) {
            try {
                send(**webhook, stop);
            } catch (const std::exception& exception) {
                warn_(std::string("a webhook was not sent: ") + exception.what());
            }
        } else {
            std::unique_lock lock(mutex_);
            woken_.wait_for(lock, stop, kPollInterval, [&] { return wakes_ != seen; });
            seen = wakes_;
        }
    }
}

/// Sends a claimed webhook, and settles it. If a stop is requested meanwhile, the attempt is repeated later.
void Webhooks::send(const JobStore::Webhook& webhook, const std::stop_token& stop) {
    const Job& job = webhook.job;
    const auto status = attempt(job, stop);
    if (!status && stop.stop_requested()) {
        (void)store_.settle_webhook(job.id, std::chrono::milliseconds(0));
        return;
    }
    const bool sent = is_success(status);
    const bool last = sent || status == kGone || webhook.attempts >= settings_.max_attempts;
    ++(sent ? sent_ : failed_);
    if (!sent)
        warn_("attempt " + std::to_string(webhook.attempts) + " of " + std::to_string(settings_.max_attempts) +
              " to send the webhook of job " + job.id + " failed" + (last ? ", and was the last one: " : ": ") +
              (status ? "the status is " + std::to_string(*status) : status.error().message));
    const auto pause = settings_.first_pause * (std::int64_t{1} << 3 * (webhook.attempts - 1));
    (void)store_.settle_webhook(job.id, last ? std::nullopt : std::optional(pause));
}

Result<int> Webhooks::attempt(const Job& job, const std::stop_token& stop) {
    if (auto checked = check_target(job.callback, settings_.hosts); !checked) return tl::unexpected(checked.error());
    const std::string body = status_json(job);
    const std::string now =
        std::to_string(std::chrono::floor<std::chrono::seconds>(time_now()).time_since_epoch().count());
    std::vector<Header> headers{{"Content-Type", "application/json"},
                                {"User-Agent", "ccdt-server"},
                                {"webhook-id", job.id},
                                {"webhook-timestamp", now}};
    {
        const std::lock_guard lock(mutex_);
        headers.push_back({"webhook-signature", webhook_signature(keys_, job.id, now, body)});
    }
    return post(job.callback, headers, body, settings_.hosts, settings_.timeout, stop);
}

}  // namespace ccdt::server
