// SPDX-License-Identifier: GPL-3.0-or-later
/// Stands in for all that needs hiredis in a server that is built without Redis. None of it is called except for the
/// destructors, because the configuration refuses the addresses of Redis.
#include <utility>

#include "server/access/shared_rate.h"
#include "server/cache/redis_cache.h"
#include "server/jobs/redis_job_store.h"
#include "server/redis/redis_client.h"

namespace ccdt::server {
namespace {

tl::unexpected<Error> absent() {
    return failure(ErrorCode::Internal, "this server was built without Redis");
}

}  // namespace

class RedisConnection::Tls {};
RedisConnection::~RedisConnection() = default;

RedisClient::RedisClient(RedisAddress address, std::chrono::milliseconds deadline, Warn warn)
    : address_(std::move(address)), deadline_(deadline), warn_(std::move(warn)) {}

Result<RedisReply> RedisClient::run(RedisCommand) {
    return absent();
}

RedisClient::Counts RedisClient::counts() const {
    return {};
}

Result<std::vector<std::string>> RedisCache::find_faults(RedisClient&) {
    return absent();
}

std::optional<api::Answer> RedisCache::find(const std::string&) {
    return std::nullopt;
}

void RedisCache::store(const std::string&, const api::Answer&) {}

Result<std::vector<std::string>> RedisJobStore::find_faults(RedisClient&) {
    return absent();
}

std::unique_ptr<JobStore> make_redis_job_store(RedisClient&, const JobLimits&, RedisJobStore::Notes) {
    return nullptr;
}

void SharedRate::set_rate(const RateLimiter::Rate&) {}

std::optional<std::chrono::seconds> SharedRate::take(const std::string&) {
    return std::nullopt;
}

}  // namespace ccdt::server
