#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/jobs/job_limits.h"
#include "server/jobs/job_news.h"
#include "server/jobs/job_store.h"
#include "server/redis/redis_client.h"
#include "server/redis/redis_subscription.h"

namespace ccdt::server {

/// Jobs in a Redis, which servers share.
///
/// What has to happen at once is a script of `redis_scripts`, whose common.lua tells what is kept under which keys;
/// large bodies go in pieces of a MiB, lest others wait, and are renamed to where they belong once they are whole. The
/// keys begin with the version of their layout, `ccdt:1:`. Jobs whose leases run out are taken from others only once
/// news have come for as long as a lease: after Redis was away all servers have the time to renew theirs.
///
/// Others may write over the keys. A damaged key is reported and repaired by the call that finds it: see repair.lua. A
/// damaged request fails its job, and a damaged result is an error (Unusable): bodies have digests.
class RedisJobStore : public JobStore {
public:
    /// Lines for the log.
    struct Notes {
        std::function<void(const std::string&)> info;
        std::function<void(const std::string&)> warning;
        std::function<void(const std::string&)> error;
    };

    /// Does not wait for Redis, which may come later. Once it is there the notes tell what of its settings loses jobs.
    /// The client must outlive it.
    RedisJobStore(RedisClient& client, const JobLimits& limits, Notes notes);

    /// Finds what of the version and the settings of a Redis loses jobs, as far as it tells its settings to us.
    /// Errors: it cannot be reached.
    static Result<std::vector<std::string>> find_faults(RedisClient& client);

    bool is_shared() const override { return true; }
    Result<bool> is_full(std::string_view client) override;
    Result<Added> add(Job& job, const ComputeRequest& request) override;
    Result<std::optional<Job>> claim(std::size_t memory) override;
    Result<std::optional<ComputeRequest>> request(const std::string& id) override;
    Result<Hold> hold(const Job& job) override;
    Result<void> give_back(const Job& job) override;
    Result<bool> take(const Job& job, const Taken& before, std::string_view piece) override;
    using JobStore::finish;
    Result<std::optional<Time>> finish(const Job& job, std::string_view result, const Taken& before) override;
    Result<std::optional<Job>> cancel(const std::string& id) override;
    Result<bool> remove(const std::string& id) override;
    Result<std::optional<Job>> find(const std::string& id) override;
    Result<std::optional<std::string>> piece(const std::string& id, std::size_t number) override;
    Result<bool> forget() override;
    Result<Load> load() override;
    void listen(JobListener* listener) override;
    std::uint64_t damages() const override { return client_.counts().damages; }

private:
    using Clock = std::chrono::steady_clock;

    Result<RedisReply> run(const RedisScript& script, const RedisCommand& arguments);
    void repair();
    Result<void> upload(const Job& job, RedisCommand fields, std::string_view body, const Taken& before);
    Result<std::optional<std::string>> download(const std::string& key, const std::string& id, std::string first,
                                                std::size_t size);
    Result<RedisReply> read(const std::string& key, RedisCommand command);
    Result<std::optional<std::string>> read_piece(const std::string& key, const std::string& id, std::size_t number);
    tl::unexpected<Error> damaged(const std::string& key);
    Result<std::optional<Job>> job_of(const std::string& id, const Result<RedisReply>& reply) const;
    RedisSubscription::Told hear();
    void tell(std::string_view news);

    const JobLimits limits_;
    const Notes notes_;
    RedisClient& client_;
    JobNews news_;
    std::atomic<Clock::time_point> hears_since_ = Clock::time_point::max();
    std::atomic<Clock::time_point> next_repair_ = Clock::time_point::min();
    RedisSubscription subscription_;  ///< last: it uses the rest
};

}  // namespace ccdt::server
