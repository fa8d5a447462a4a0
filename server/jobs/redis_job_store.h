// SPDX-License-Identifier: GPL-3.0-or-later
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
#include "server/jobs/job_notifier.h"
#include "server/jobs/job_store.h"
#include "server/redis/redis_client.h"
#include "server/redis/redis_subscription.h"

namespace ccdt::server {

/// Jobs in a Redis that servers share.
///
/// The scripts in `redis_scripts` make operations atomic; common.lua describes the keys. All keys begin with the
/// version of their layout, `ccdt:1:`. Large bodies are sent to a temporary key, in pieces of 1 MiB, so that other
/// calls are not delayed. When the body is complete, its key gets its final name.
///
/// After an outage of Redis, all servers get time to renew their leases: a server claims jobs with expired leases only
/// after its subscription to notifications has lasted for the duration of a lease.
///
/// Other programs may overwrite keys. The call that finds a damaged key reports and repairs it (see repair.lua). Bodies
/// have digests. A damaged request makes its job fail; reading a damaged result returns an error (Unusable).
class RedisJobStore : public JobStore {
public:
    /// Functions that write log messages.
    struct Notes {
        std::function<void(const std::string&)> info;
        std::function<void(const std::string&)> warning;
        std::function<void(const std::string&)> error;
    };

    /// Does not wait for the connection to Redis. Once the connection is established, logs warnings about settings of
    /// Redis that may cause a loss of jobs. `client` must outlive this object.
    RedisJobStore(RedisClient& client, const JobLimits& limits, Notes notes);

    /// Describes faults of a Redis that may cause a loss of jobs. Checks the version, and the settings that Redis
    /// permits reading.
    /// Errors: Redis cannot be reached.
    static Result<std::vector<std::string>> find_faults(RedisClient& client);

    bool is_shared() const override { return true; }
    Result<bool> is_full(std::string_view client) override;
    Result<Added> add(Job& job, const ComputeRequest& request) override;
    Result<std::optional<Job>> claim(std::size_t memory) override;
    Result<std::optional<ComputeRequest>> request(const std::string& id) override;
    Result<Renewal> renew(const Job& job) override;
    Result<void> requeue(const Job& job, bool counted) override;
    Result<bool> append_piece(const Job& job, const StoredPart& before, std::string_view piece) override;
    using JobStore::finish;
    Result<std::optional<Time>> finish(const Job& job, std::string_view result, const StoredPart& before) override;
    Result<std::optional<Job>> cancel(const std::string& id) override;
    Result<std::optional<Webhook>> claim_webhook(std::chrono::milliseconds lease) override;
    Result<void> settle_webhook(const std::string& id, std::optional<std::chrono::milliseconds> pause) override;
    Result<bool> remove(const std::string& id) override;
    Result<std::optional<Job>> find(const std::string& id) override;
    Result<std::optional<std::string>> piece(const std::string& id, std::size_t number) override;
    Result<bool> remove_expired() override;
    Result<Load> load() override;
    void listen(JobListener* listener) override;
    std::uint64_t damages() const override { return client_.counts().damages; }

private:
    using Clock = std::chrono::steady_clock;

    Result<RedisReply> run(const RedisScript& script, const RedisCommand& arguments);
    void repair();
    Result<void> upload(const Job& job, RedisCommand fields, std::string_view body, const StoredPart& before);
    Result<std::optional<std::string>> download(const std::string& key, const std::string& id, std::string first,
                                                std::size_t size);
    Result<RedisReply> read(const std::string& key, RedisCommand command);
    Result<std::optional<std::string>> read_piece(const std::string& key, const std::string& id, std::size_t number);
    tl::unexpected<Error> damaged(const std::string& key);
    Result<std::optional<Job>> job_of(const std::string& id, const Result<RedisReply>& reply) const;
    RedisSubscription::Callbacks callbacks();
    void forward(std::string_view message);

    const JobLimits limits_;
    const Notes notes_;
    RedisClient& client_;
    JobNotifier notifier_;
    std::atomic<Clock::time_point> subscribed_since_ = Clock::time_point::max();
    std::atomic<Clock::time_point> next_repair_ = Clock::time_point::min();
    RedisSubscription subscription_;  ///< last, because it uses the other members
};

/// Creates a RedisJobStore.
std::unique_ptr<JobStore> make_redis_job_store(RedisClient& client, const JobLimits& limits,
                                               RedisJobStore::Notes notes);

}  // namespace ccdt::server
