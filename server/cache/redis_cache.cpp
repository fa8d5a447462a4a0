// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/cache/redis_cache.h"

#include <charconv>
#include <string_view>
#include <utility>
#include <vector>

#include "api/text/text.h"
#include "server/requests/digest.h"

namespace ccdt::server {
namespace {

/// Prefix of the Redis keys. The number is the version of the stored layout.
constexpr std::string_view kPrefix = "ccdt:2:answer:";

constexpr std::string_view kSecondsKept = "86400";

template <class Number>
std::string text_of(Number number) {
    char text[32];
    return {text, std::to_chars(std::begin(text), std::end(text), number).ptr};
}

template <class Number>
Number number_of(const RedisReply& reply) {
    return api::parse_number<Number>(reply.text).value_or(Number{});
}

}  // namespace

Result<std::vector<std::string>> RedisCache::find_faults(RedisClient& client) {
    if (const auto there = client.run(RedisCommand{"PING"}); !there) return tl::unexpected(there.error());
    if (client.setting("maxmemory-policy") != "noeviction") return std::vector<std::string>();
    return std::vector{"Redis at " + client.address().name() +
                       " keeps no more answers once its memory is full (maxmemory-policy volatile-lru)"};
}

std::optional<api::Answer> RedisCache::find(const std::string& name) {
    const std::string key = std::string(kPrefix) + name;
    auto reply = client_.run(RedisCommand{"HMGET", key, "body", "media_type", "coding", "sites", "pixels", "repaired",
                                          "warnings", "repeats", "radius", "tone", "plot_seconds", "digest"});
    if (!reply && reply.error().code == ErrorCode::Unusable) return drop_damaged(key);
    if (!reply || reply->items.size() != 12 || reply->items[0].kind != RedisReply::Kind::Text) return std::nullopt;
    auto& items = reply->items;
    Digest digest;
    digest.add(name);
    for (std::size_t i = 0; i < 11; ++i) digest.add(items[i].text);
    if (items[11].text != digest.finish()) return drop_damaged(key);
    api::Answer answer;
    answer.body = std::move(items[0].text);
    answer.media_type = std::move(items[1].text);
    answer.coding = std::move(items[2].text);
    answer.sites = number_of<std::size_t>(items[3]);
    answer.pixels = number_of<std::size_t>(items[4]);
    answer.repaired = std::move(items[5].text);
    answer.warnings = std::move(items[6].text);
    answer.repeats = number_of<int>(items[7]) != 0;
    if (!items[8].text.empty()) answer.dots = api::DotSize{number_of<double>(items[8]), number_of<double>(items[9])};
    if (!items[10].text.empty()) answer.plot = api::PlotSize{number_of<double>(items[10])};
    return answer;
}

/// Reports and removes an entry that another program has overwritten.
std::nullopt_t RedisCache::drop_damaged(const std::string& key) {
    client_.report_damage(key, "it is computed again");
    (void)client_.run(RedisCommand{"UNLINK", key});
    return std::nullopt;
}

void RedisCache::store(const std::string& name, const api::Answer& answer) {
    if (answer.body.size() > kLargest) return;
    const std::string key = std::string(kPrefix) + name;
    const std::string sites = text_of(answer.sites);
    const std::string pixels = text_of(answer.pixels);
    const std::string radius = answer.dots ? text_of(answer.dots->radius) : "";
    const std::string tone = answer.dots ? text_of(answer.dots->tone) : "";
    const std::string plot_seconds = answer.plot ? text_of(answer.plot->seconds) : "";
    RedisCommand store{"HSET",         key,
                       "body",         answer.body,
                       "media_type",   answer.media_type,
                       "coding",       answer.coding,
                       "sites",        sites,
                       "pixels",       pixels,
                       "repaired",     answer.repaired,
                       "warnings",     answer.warnings,
                       "repeats",      answer.repeats ? "1" : "0",
                       "radius",       radius,
                       "tone",         tone,
                       "plot_seconds", plot_seconds};
    Digest digest;
    digest.add(name);
    for (std::size_t value = 3; value < store.size(); value += 2) digest.add(store[value]);
    const std::string text = digest.finish();
    store.insert(store.end(), {"digest", text});
    const std::vector<RedisCommand> commands{std::move(store), {"EXPIRE", key, kSecondsKept}};
    (void)client_.run(commands);  // failures are ignored: a missing answer is computed again
}

}  // namespace ccdt::server
