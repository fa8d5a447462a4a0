// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/redis_job_store.h"

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include "api/text/text.h"
#include "server/jobs/redis_scripts.h"
#include "server/requests/digest.h"

namespace ccdt::server {
namespace {

/// Prefix of all keys. The number is the version of their layout.
constexpr std::string_view kPrefix = "ccdt:1:";

/// Maximum size of a body, in bytes, that is sent as an argument of the script that stores it. This saves one round
/// trip and one wait for the disk. Larger bodies are sent by separate calls before the script runs: scripts copy their
/// arguments several times, and Redis serves no other client meanwhile.
constexpr std::size_t kSmall = std::size_t{64} << 10;

/// Time in seconds after which temporary keys with pieces expire.
constexpr std::string_view kPiecesKept = "600";

/// Number of jobs that one call deletes; more would delay other calls.
constexpr std::int64_t kRemovedAtOnce = 100;

/// The first version of Redis whose scripts have flags.
constexpr int kMinVersion = 7;

/// Flags of scripts that may run when the memory of Redis is full, because they free memory or need very little.
constexpr std::string_view kAnyway = "allow-oom";
constexpr std::string_view kReads = "no-writes,allow-oom";

/// Minimum time until the next repair if a call still fails after a repair. Limits the load, because a repair reads all
/// jobs.
constexpr std::chrono::seconds kRepairPause{1};

RedisScript script(std::string_view flags, std::string_view text) {
    return {flags, {redis_scripts::common, redis_scripts::intact, text}};
}

const RedisScript kIsFull = script(kReads, redis_scripts::is_full);
const RedisScript kAdd = script("", redis_scripts::add);
const RedisScript kClaim = script(kAnyway, redis_scripts::claim);
const RedisScript kRenew = script(kAnyway, redis_scripts::renew);
const RedisScript kRequeue = script(kAnyway, redis_scripts::requeue);
const RedisScript kFinish = script(kAnyway, redis_scripts::finish);
const RedisScript kCancel = script(kAnyway, redis_scripts::cancel);
const RedisScript kClaimWebhook = script(kAnyway, redis_scripts::claim_webhook);
const RedisScript kSettleWebhook = script(kAnyway, redis_scripts::settle_webhook);
const RedisScript kRemove = script(kAnyway, redis_scripts::remove);
const RedisScript kFind(kReads, {redis_scripts::common, redis_scripts::find});
const RedisScript kRemoveExpired = script(kAnyway, redis_scripts::remove_expired);
const RedisScript kLoad = script(kReads, redis_scripts::load);
const RedisScript kRepair(kAnyway, {redis_scripts::common, redis_scripts::repair});

std::string key_of(std::string_view kind, const std::string& id) {
    return std::string(kPrefix).append(kind).append(":").append(id);
}

/// Returns the temporary key of a body that is not complete yet.
std::string key_of_pieces(const Job& job) {
    return key_of("pieces", job.id) + ':' + std::to_string(job.claim);
}

std::string name_of_digest(std::size_t number) {
    return "digest:" + std::to_string(number);
}

/// Computes the digest of a request without its body.
std::string digest_of_head(std::string_view path, std::string_view query, std::string_view content_type,
                           std::string_view accept) {
    Digest digest;
    for (const std::string_view text : {path, query, content_type, accept}) digest.add(text);
    return digest.finish();
}

template <class Number>
std::string text_of(Number number) {
    char text[32];
    return {text, std::to_chars(std::begin(text), std::end(text), number).ptr};
}

std::string text_of(std::chrono::milliseconds time) {
    return std::to_string(time.count());
}

tl::unexpected<Error> not_understood(const std::string& what) {
    return failure(ErrorCode::Unusable, "the data of " + what + " in Redis is not what was written");
}

/// The names and values of a hash.
class Fields {
public:
    explicit Fields(const RedisReply& reply) {
        for (std::size_t i = 0; i + 1 < reply.items.size(); i += 2)
            values_.emplace(reply.items[i].text, reply.items[i + 1].text);
    }

    std::string text(std::string_view name) const {
        const auto found = values_.find(name);
        return found == values_.end() ? "" : std::string(found->second);
    }

    template <class Number>
    std::optional<Number> find(std::string_view name) const {
        const auto found = values_.find(name);
        return found == values_.end() ? std::nullopt : api::parse_number<Number>(found->second);
    }

    template <class Number>
    Number number(std::string_view name) const {
        return find<Number>(name).value_or(Number{});
    }

    std::optional<Time> time(std::string_view name) const {
        const auto number = find<std::int64_t>(name);
        return number ? std::optional(Time(std::chrono::milliseconds(*number))) : std::nullopt;
    }

private:
    std::map<std::string_view, std::string_view> values_;
};

/// Returns the names and values that are stored at the end of a job.
std::vector<std::string> fields_of_end(const Job& job) {
    std::vector<std::string> fields{
        "status",    std::string(name_of(job.status)), "fraction",   text_of(job.progress.fraction),
        "iteration", text_of(job.progress.iteration),  "media_type", job.media_type,
        "partial",   job.partial ? "1" : "0",          "headers",    server::text_of(job.headers)};
    const auto add = [&](const char* name, std::string value) {
        fields.emplace_back(name);
        fields.push_back(std::move(value));
    };
    if (job.progress.variation) add("variation", text_of(*job.progress.variation));
    if (job.failure) {
        add("failure", text_of(job.failure->status));
        add("message", job.failure->error.message);
        add("field", job.failure->error.field);
    }
    return fields;
}

/// Returns the value of a line `name:value` in the output of INFO.
std::string line_of(const std::string& info, std::string_view name) {
    std::string_view rest = info;
    while (!rest.empty()) {
        auto line = api::take_until(rest, "\r\n");
        if (api::take_until(line, ":") == name) return std::string(line);
    }
    return {};
}

}  // namespace

RedisJobStore::RedisJobStore(RedisClient& client, const JobLimits& limits, Notes notes)
    : limits_(limits),
      notes_(std::move(notes)),
      client_(client),
      subscription_(client.address(), std::string(kPrefix) + "news", callbacks()) {}

RedisSubscription::Callbacks RedisJobStore::callbacks() {
    return {.message = [this](std::string_view message) { forward(message); },
            .begun =
                [this] {
                    notes_.info("jobs are stored in Redis at " + client_.address().name());
                    for (const auto& fault : find_faults(client_).value_or(std::vector<std::string>()))
                        notes_.warning(fault);
                    subscribed_since_ = Clock::now();
                    notifier_.notify([](JobListener& listener) { listener.missed(); });
                },
            .ended =
                [this](const Error& error) {
                    subscribed_since_ = Clock::time_point::max();
                    notes_.error("jobs have to wait: " + error.message);
                }};
}

void RedisJobStore::listen(JobListener* listener) {
    notifier_.listen(listener);
    if (subscribed_since_.load() != Clock::time_point::max())
        notifier_.notify([](JobListener& now) { now.missed(); });  // otherwise called when subscribed
}

void RedisJobStore::forward(std::string_view message) {
    const auto what = api::take_until(message, " ");
    const std::string id(message);
    notifier_.notify([&](JobListener& listener) {
        if (what == "work") listener.work();
        if (what == "changed") listener.changed(id);
        if (what == "stop") listener.stop(id);
    });
}

Result<std::vector<std::string>> RedisJobStore::find_faults(RedisClient& client) {
    const auto server = client.run(RedisCommand{"INFO", "server"});
    if (!server) return tl::unexpected(server.error());
    const std::string position = "Redis at " + client.address().name();
    const std::string version = line_of(server->text, "redis_version");
    std::string_view major = version;
    std::vector<std::string> faults;
    if (!version.empty() && api::parse_number<int>(api::take_until(major, ".")).value_or(0) < kMinVersion)
        faults.push_back(position + " has version " + version + "; jobs need 7.0 or later");
    if (client.setting("appendonly") == "no")
        faults.push_back(position + " has no append-only file: it loses jobs when it ends (appendonly yes)");
    if (client.setting("appendfsync") == "no")
        faults.push_back(position + " does not flush its writes to the disk (appendfsync always or everysec)");
    if (client.setting("maxmemory-policy").starts_with("allkeys"))
        faults.push_back(position + " drops jobs when its memory is full (maxmemory-policy noeviction)");
    return faults;
}

Result<RedisReply> RedisJobStore::run(const RedisScript& script, const RedisCommand& arguments) {
    auto reply = client_.run(script, kPrefix, arguments);
    if (reply) return reply;
    const auto code = reply.error().code;
    const bool may_be_damage = code == ErrorCode::Unusable || code == ErrorCode::Internal;
    if (!may_be_damage || Clock::now() < next_repair_.load()) return reply;
    repair();
    reply = client_.run(script, kPrefix, arguments);
    if (!reply) next_repair_ = Clock::now() + kRepairPause;
    return reply;
}

/// Repairs all damaged keys, and reports them.
void RedisJobStore::repair() {
    const std::string bytes = std::to_string(bytes_of_job(0));
    const std::string lease = text_of(limits_.lease);
    const auto reply = client_.run(kRepair, kPrefix, {bytes, lease});
    if (!reply) return;
    const std::string jobs = key_of("job", "");
    for (const auto& key : reply->items)
        client_.report_damage(
            key.text, key.text.starts_with(jobs) ? "the job has failed, or is lost" : "it was rebuilt from the jobs");
}

/// Reports a damaged body, and returns the error for the client.
tl::unexpected<Error> RedisJobStore::damaged(const std::string& key) {
    client_.report_damage(key, "clients get an error");
    return failure(ErrorCode::Unusable, "the data of this job in Redis is damaged");
}

/// Runs a command that reads a body.
Result<RedisReply> RedisJobStore::read(const std::string& key, RedisCommand command) {
    auto reply = client_.run(std::move(command));
    if (!reply && reply.error().code == ErrorCode::Unusable) return damaged(key);
    return reply;
}

/// Reads a piece of a body.
/// @returns  none if the piece does not exist
Result<std::optional<std::string>> RedisJobStore::read_piece(const std::string& key, const std::string& id,
                                                             std::size_t number) {
    const std::string name = std::to_string(number), digest = name_of_digest(number);
    auto reply = read(key, {"HMGET", key, name, digest});
    if (!reply) return tl::unexpected(reply.error());
    if (reply->items.size() != 2 || reply->items[0].kind == RedisReply::Kind::Nothing) return std::nullopt;
    std::string piece = std::move(reply->items[0].text);
    if (reply->items[1].text != digest_of_piece(id, number, piece)) return damaged(key);
    return piece;
}

/// Sends fields, and a body in pieces, to the temporary key of a job. The key expires unless it is renamed.
/// @param before  part of the body that was already sent
Result<void> RedisJobStore::upload(const Job& job, RedisCommand fields, std::string_view body,
                                   const StoredPart& before) {
    const std::string key = key_of_pieces(job);
    const std::string size = std::to_string(before.bytes + body.size());
    fields.insert(fields.begin(), {"HSET", key, "size", size});
    std::size_t number = before.pieces;
    do {
        const auto piece = body.substr(0, kPiece);
        const std::string name = std::to_string(number), name_of_its_digest = name_of_digest(number);
        const std::string digest = digest_of_piece(job.id, number++, piece);
        fields.insert(fields.end(), {name, piece, name_of_its_digest, digest});
        body.remove_prefix(std::min(kPiece, body.size()));
        const std::vector<RedisCommand> commands{std::move(fields), {"EXPIRE", key, kPiecesKept}};
        if (const auto sent = client_.run(commands); !sent) return tl::unexpected(sent.error());
        fields = {"HSET", key};
    } while (!body.empty());
    return {};
}

/// Reads the pieces of a body after `first`, its first piece, and returns the whole body.
/// @param size  size of the whole body, in bytes
/// @returns     none if the pieces no longer exist
Result<std::optional<std::string>> RedisJobStore::download(const std::string& key, const std::string& id,
                                                           std::string first, std::size_t size) {
    std::string body = std::move(first);
    for (std::size_t number = 1; body.size() < size; ++number) {
        const auto piece = read_piece(key, id, number);
        if (!piece) return tl::unexpected(piece.error());
        if (!*piece || (*piece)->empty()) return std::nullopt;
        body += **piece;
    }
    if (body.size() != size) return damaged(key);
    return body;
}

Result<std::optional<Job>> RedisJobStore::job_of(const std::string& id, const Result<RedisReply>& reply) const {
    if (!reply) return tl::unexpected(reply.error());
    if (reply->kind == RedisReply::Kind::Nothing) return std::nullopt;
    const Fields fields(*reply);
    const auto status = status_named(fields.text("status"));
    const auto created = fields.time("created");
    if (!status || !created) return not_understood("job " + id);
    Job job;
    job.id = id;
    job.owner = fields.text("owner");
    job.client = fields.text("client");
    job.traceparent = fields.text("traceparent");
    job.callback = fields.text("callback");
    job.cost = {fields.number<std::size_t>("memory"), fields.number<double>("seconds")};
    job.status = *status;
    job.starts = fields.number<int>("starts");
    job.claim = fields.number<std::uint64_t>("claim");
    job.created = *created;
    job.started = fields.time("started");
    job.finished = fields.time("finished");
    job.progress = {fields.number<double>("fraction"), fields.number<int>("iteration"),
                    fields.find<double>("variation")};
    if (const auto failed = fields.find<int>("failure"))
        job.failure = Problem{*failed, {ErrorCode::Internal, fields.text("message"), fields.text("field")}};
    job.media_type = fields.text("media_type");
    job.result_bytes = fields.number<std::size_t>("result_bytes");
    job.partial = fields.number<int>("partial") != 0;
    job.headers = headers_in(fields.text("headers"));
    job.dropped = fields.number<int>("dropped") != 0;
    return job;
}

Result<bool> RedisJobStore::is_full(std::string_view client) {
    const std::string limit = std::to_string(limits_.waiting);
    return run(kIsFull, {client, limit}).map([](const RedisReply& reply) { return reply.number != 0; });
}

Result<JobStore::Added> RedisJobStore::add(Job& job, const ComputeRequest& request) {
    const std::string head = digest_of_head(request.path, request.query, request.content_type, request.accept);
    RedisCommand fields{"path",   request.path,   "query",  request.query, "content_type", request.content_type,
                        "accept", request.accept, "digest", head};
    const std::string pieces = request.body.size() > kSmall ? key_of_pieces(job) : "";
    if (!pieces.empty()) {
        if (const auto uploaded = upload(job, fields, request.body, {}); !uploaded)
            return tl::unexpected(uploaded.error());
    }
    const std::string bytes = std::to_string(bytes_of_job(bytes_of(request)));
    const std::string waiting = std::to_string(limits_.waiting);
    const std::string limit = std::to_string(limits_.bytes);
    const std::string memory = std::to_string(job.cost.memory);
    const std::string seconds = text_of(job.cost.seconds);
    RedisCommand arguments{job.id,     pieces, bytes,   waiting,         limit,       job.owner,
                           job.client, memory, seconds, job.traceparent, job.callback};
    const std::string size = std::to_string(request.body.size());
    const std::string digest = pieces.empty() ? digest_of_piece(job.id, 0, request.body) : "";
    if (pieces.empty()) {
        arguments.insert(arguments.end(), fields.begin(), fields.end());
        arguments.insert(arguments.end(), {"size", size, "0", request.body, "digest:0", digest});
    }
    const auto reply = run(kAdd, arguments);
    if (!reply) return tl::unexpected(reply.error());
    if (reply->items.empty()) return not_understood("job " + job.id);
    if (reply->items[0].text == "full") return Added::QueueFull;
    if (reply->items[0].text == "store full") return Added::StoreFull;
    const auto created = api::parse_number<std::int64_t>(reply->items.back().text);
    job.created = Time(std::chrono::milliseconds(created.value_or(0)));
    return Added::Accepted;
}

Result<std::optional<Job>> RedisJobStore::claim(std::size_t memory) {
    const std::string limit = std::to_string(memory);
    const std::string lease = text_of(limits_.lease);
    const auto since = subscribed_since_.load();
    const bool all_had_time = since < Clock::now() && Clock::now() - since >= limits_.lease;
    const auto reply = run(kClaim, {limit, lease, all_had_time ? "1" : "0"});
    if (!reply) return tl::unexpected(reply.error());
    if (reply->items.size() != 2) return std::nullopt;
    return job_of(reply->items[0].text, reply->items[1]);
}

Result<std::optional<ComputeRequest>> RedisJobStore::request(const std::string& id) {
    const std::string key = key_of("question", id);
    auto reply =
        read(key, {"HMGET", key, "path", "query", "content_type", "accept", "size", "0", "digest:0", "digest"});
    if (!reply) return tl::unexpected(reply.error());
    auto& items = reply->items;
    if (items.size() != 8 || items[4].kind == RedisReply::Kind::Nothing) return std::nullopt;
    const auto size = api::parse_number<std::size_t>(items[4].text);
    const bool sound = size && items[6].text == digest_of_piece(id, 0, items[5].text) &&
                       items[7].text == digest_of_head(items[0].text, items[1].text, items[2].text, items[3].text);
    if (!sound) return damaged(key);
    auto body = download(key, id, std::move(items[5].text), *size);
    if (!body) return tl::unexpected(body.error());
    if (!*body) return std::nullopt;
    return ComputeRequest{items[0].text, items[1].text, items[2].text, items[3].text, **std::move(body)};
}

Result<JobStore::Renewal> RedisJobStore::renew(const Job& job) {
    const std::string claim = std::to_string(job.claim);
    const std::string lease = text_of(limits_.lease);
    const std::string fraction = text_of(job.progress.fraction);
    const std::string iteration = text_of(job.progress.iteration);
    const std::string variation = job.progress.variation ? text_of(*job.progress.variation) : "";
    const auto reply = run(kRenew, {job.id, claim, lease, name_of(job.status), fraction, iteration, variation});
    if (!reply) return tl::unexpected(reply.error());
    if (reply->items.size() != 2) return not_understood("job " + job.id);
    const std::string& owned = reply->items[0].text;
    const auto now = api::parse_number<std::int64_t>(reply->items[1].text);
    return Renewal{owned == "still"       ? Owned::Still
                   : owned == "cancelled" ? Owned::Cancelled
                                          : Owned::Lost,
                   Time(std::chrono::milliseconds(now.value_or(0)))};
}

Result<void> RedisJobStore::requeue(const Job& job, bool counted) {
    const std::string claim = std::to_string(job.claim);
    return run(kRequeue, {job.id, claim, counted ? "1" : "0"}).map([](const RedisReply&) {});
}

Result<bool> RedisJobStore::append_piece(const Job& job, const StoredPart& before, std::string_view piece) {
    const std::size_t whole = before.bytes + piece.size();
    if (bytes_of_job(whole) > limits_.bytes) return no_space_for(whole);
    const std::string pieces = key_of_pieces(job), known = key_of("job", job.id),
                      leases = std::string(kPrefix) + "leases";
    const std::string number = std::to_string(before.pieces), name = name_of_digest(before.pieces);
    const std::string digest = digest_of_piece(job.id, before.pieces, piece);
    const auto replies = client_.run(std::vector<RedisCommand>{{"HSET", pieces, number, piece, name, digest},
                                                               {"EXPIRE", pieces, kPiecesKept},
                                                               {"HGET", known, "claim"},
                                                               {"ZSCORE", leases, job.id}});
    if (!replies) return tl::unexpected(replies.error());
    const bool owned = (*replies)[2].text == std::to_string(job.claim);
    return owned && (*replies)[3].kind != RedisReply::Kind::Nothing;
}

Result<std::optional<Time>> RedisJobStore::finish(const Job& job, std::string_view result, const StoredPart& before) {
    const std::size_t whole = before.bytes + result.size();
    if (whole > 0 && bytes_of_job(whole) > limits_.bytes) return no_space_for(whole);
    const std::string pieces = result.size() > kSmall || before.pieces > 0 ? key_of_pieces(job) : "";
    if (!pieces.empty()) {
        if (const auto uploaded = upload(job, {}, result, before); !uploaded) return tl::unexpected(uploaded.error());
        const auto fields = client_.run(RedisCommand{"HLEN", pieces});
        if (!fields) return tl::unexpected(fields.error());
        const std::size_t last = std::max<std::size_t>(1, (result.size() + kPiece - 1) / kPiece);
        if (fields->number != static_cast<std::int64_t>(1 + 2 * (before.pieces + last)))
            return failure(ErrorCode::Internal, "the pieces of the result in Redis are lost");
    }
    const std::string claim = std::to_string(job.claim);
    const std::string size = std::to_string(whole);
    const std::string bytes = std::to_string(bytes_of_job(whole));
    const std::string limit = std::to_string(limits_.bytes);
    const bool goes_along = pieces.empty();
    const std::string digest = goes_along ? digest_of_piece(job.id, 0, result) : "";
    const std::string used = text_of(job.used);
    RedisCommand arguments{job.id, claim, pieces, size, bytes, limit, goes_along ? result : "", digest, used};
    const auto fields = fields_of_end(job);
    arguments.insert(arguments.end(), fields.begin(), fields.end());
    const auto reply = run(kFinish, arguments);
    if (!reply) return tl::unexpected(reply.error());
    if (reply->items.empty()) return not_understood("job " + job.id);
    if (reply->items[0].text == "store full") return no_space_for(whole);
    if (reply->items[0].text == "lost") return std::nullopt;
    const auto finished = api::parse_number<std::int64_t>(reply->items.back().text);
    return Time(std::chrono::milliseconds(finished.value_or(0)));
}

Result<std::optional<Job>> RedisJobStore::cancel(const std::string& id) {
    const std::string bytes = std::to_string(bytes_of_job(0));
    return job_of(id, run(kCancel, {id, bytes}));
}

Result<std::optional<JobStore::Webhook>> RedisJobStore::claim_webhook(std::chrono::milliseconds lease) {
    const auto reply = run(kClaimWebhook, {text_of(lease)});
    if (!reply) return tl::unexpected(reply.error());
    if (reply->items.size() != 3) return std::nullopt;
    const int attempts = static_cast<int>(reply->items[1].number);
    auto job = job_of(reply->items[0].text, reply->items[2]);
    if (!job) return tl::unexpected(job.error());
    if (!*job) return std::nullopt;
    return Webhook{**std::move(job), attempts};
}

Result<void> RedisJobStore::settle_webhook(const std::string& id, std::optional<std::chrono::milliseconds> pause) {
    return run(kSettleWebhook, {id, pause ? text_of(*pause) : ""}).map([](const RedisReply&) {});
}

Result<bool> RedisJobStore::remove(const std::string& id) {
    return run(kRemove, {id}).map([](const RedisReply& reply) { return reply.number != 0; });
}

Result<std::optional<Job>> RedisJobStore::find(const std::string& id) {
    const std::string ttl = text_of(limits_.ttl);
    return job_of(id, run(kFind, {id, ttl}));
}

Result<std::optional<std::string>> RedisJobStore::piece(const std::string& id, std::size_t number) {
    return read_piece(key_of("result", id), id, number);
}

Result<bool> RedisJobStore::remove_expired() {
    const std::string ttl = text_of(limits_.ttl);
    const std::string limit = std::to_string(kRemovedAtOnce);
    return run(kRemoveExpired, {ttl, limit}).map([](const RedisReply& reply) {
        return reply.number == kRemovedAtOnce;
    });
}

Result<JobStore::Load> RedisJobStore::load() {
    const auto reply = run(kLoad, {});
    if (!reply) return tl::unexpected(reply.error());
    if (reply->items.size() != 3) return not_understood("the queue");
    const auto number = [&](std::size_t position) { return static_cast<std::size_t>(reply->items[position].number); };
    return Load{number(0), number(1), number(2)};
}

std::unique_ptr<JobStore> make_redis_job_store(RedisClient& client, const JobLimits& limits,
                                               RedisJobStore::Notes notes) {
    return std::make_unique<RedisJobStore>(client, limits, std::move(notes));
}

}  // namespace ccdt::server
