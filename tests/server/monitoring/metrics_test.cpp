// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/monitoring/metrics.h"

#include <gtest/gtest.h>

#include <ctime>
#include <string>
#include <thread>
#include <vector>

namespace ccdt::server {
namespace {

Exchange exchange(std::string_view route, int status) {
    Exchange exchange;
    exchange.response.record.route = route;
    exchange.response.status = status;
    exchange.milliseconds = 20;
    exchange.bytes_in = 10;
    exchange.bytes_out = 1000;
    return exchange;
}

/// Returns the value of a sample, given by its name and labels; -1 if there is no such sample.
double value(const std::string& text, const std::string& sample) {
    const auto line = ("\n" + text).find("\n" + sample + " ");
    return line == std::string::npos ? -1 : std::stod(text.substr(line + sample.size() + 1));
}

TEST(Metrics, CountsRequestsByRouteAndStatus) {
    Metrics metrics("1.2.3");
    for (int i = 0; i < 3; ++i) metrics.add(exchange("/sample", 200));
    metrics.add(exchange("/sample", 400));
    metrics.add(exchange("", 404));
    const std::string text = metrics.text({});
    EXPECT_EQ(value(text, R"(ccdt_build_info{version="1.2.3"})"), 1);
    EXPECT_EQ(value(text, R"(ccdt_http_requests_total{route="/sample",status="200"})"), 3);
    EXPECT_EQ(value(text, R"(ccdt_http_requests_total{route="/sample",status="400"})"), 1);
    EXPECT_EQ(value(text, R"(ccdt_http_requests_total{route="other",status="404"})"), 1);
    EXPECT_EQ(value(text, R"(ccdt_http_request_duration_seconds_count{route="/sample"})"), 4);
    EXPECT_NEAR(value(text, R"(ccdt_http_request_duration_seconds_sum{route="/sample"})"), 0.08, 1e-9);
    EXPECT_EQ(value(text, "ccdt_http_received_bytes_total"), 50);
    EXPECT_EQ(value(text, "ccdt_http_sent_bytes_total"), 5000);
}

TEST(Metrics, CountsJobsByOutcome) {
    Metrics metrics("1");
    Metrics::Watched watched;
    watched.jobs = {.queued = 4, .running = 2, .bytes = 99};
    watched.job_runs = {.lost = 5, .repeated = 6};
    watched.redis.jobs = {.calls = 9, .failures = 8, .seconds = 0.5};
    watched.redis.rates.calls = 7;
    watched.job_capacity = 1000;
    metrics.watch([&] { return watched; });
    JobEnd end;
    end.job.status = JobStatus::Succeeded;
    end.computed = Computed{5000, 0};
    end.stages.work.optimise = 200;
    metrics.add(end);
    end.job.status = JobStatus::Cancelled;
    end.computed.reset();
    metrics.add(end);
    const std::string text = metrics.text({});
    EXPECT_EQ(value(text, R"(ccdt_jobs_ended_total{status="succeeded"})"), 1);
    EXPECT_EQ(value(text, R"(ccdt_jobs_ended_total{status="cancelled"})"), 1);
    EXPECT_EQ(value(text, R"(ccdt_jobs_ended_total{status="failed"})"), 0);
    EXPECT_EQ(value(text, R"(ccdt_jobs{status="queued"})"), 4);
    EXPECT_EQ(value(text, R"(ccdt_jobs{status="running"})"), 2);
    EXPECT_EQ(value(text, "ccdt_job_store_bytes"), 99);
    EXPECT_EQ(value(text, R"(ccdt_redis_calls_total{use="jobs"})"), 9);
    EXPECT_EQ(value(text, R"(ccdt_redis_calls_total{use="rates"})"), 7);
    EXPECT_EQ(value(text, R"(ccdt_redis_failures_total{use="jobs"})"), 8);
    EXPECT_EQ(value(text, R"(ccdt_redis_seconds_total{use="jobs"})"), 0.5);
    EXPECT_EQ(value(text, "ccdt_job_leases_lost_total"), 5);
    EXPECT_EQ(value(text, "ccdt_job_runs_repeated_total"), 6);
    EXPECT_EQ(value(text, "ccdt_job_store_capacity_bytes"), 1000);
    EXPECT_EQ(value(text, "ccdt_sites_total"), 5000);
    EXPECT_EQ(value(text, R"(ccdt_stage_duration_seconds_count{stage="optimise"})"), 1);
}

TEST(Metrics, CountsComputedAndCancelledWork) {
    Metrics metrics("1");
    Exchange done = exchange("/halftone", 200);
    done.response.record.computed = Computed{5000, 262144};
    done.response.record.stages = {
        .queue = 1, .work = {.decode = 30, .optimise = 200, .encode = 4, .processor = 350, .threads = 2}};
    metrics.add(done);
    Exchange late = exchange("/halftone", 504);
    late.response.record.cancelled = "deadline";
    metrics.add(late);
    const std::string text = metrics.text({});
    EXPECT_EQ(value(text, "ccdt_sites_total"), 5000);
    EXPECT_EQ(value(text, "ccdt_pixels_total"), 262144);
    EXPECT_EQ(value(text, R"(ccdt_stage_duration_seconds_bucket{stage="decode",le="0.025"})"), 0);
    EXPECT_EQ(value(text, R"(ccdt_stage_duration_seconds_bucket{stage="decode",le="0.05"})"), 1);
    EXPECT_EQ(value(text, R"(ccdt_stage_duration_seconds_count{stage="queue"})"), 1);
    EXPECT_EQ(value(text, R"(ccdt_computation_threads_bucket{le="1"})"), 0);
    EXPECT_EQ(value(text, R"(ccdt_computation_threads_bucket{le="2"})"), 1);
    EXPECT_EQ(value(text, "ccdt_computation_cpu_seconds_total"), 0.35);
    EXPECT_EQ(value(text, R"(ccdt_cancellations_total{cause="deadline"})"), 1);
    EXPECT_EQ(value(text, R"(ccdt_cancellations_total{cause="client_gone"})"), 0);
}

TEST(Metrics, ReportsThePoolAndTheProcess) {
    const Metrics metrics("1");
    const std::string text = metrics.text({.workers = 4,
                                           .busy = 3,
                                           .waiting = 7,
                                           .capacity = 64,
                                           .oldest_seconds = 1.5,
                                           .backlog_seconds = 2.5,
                                           .overdue_seconds = 0.25});
    EXPECT_EQ(value(text, "ccdt_workers"), 4);
    EXPECT_EQ(value(text, "ccdt_workers_busy"), 3);
    EXPECT_EQ(value(text, "ccdt_workers_overdue_seconds"), 0.25);
    EXPECT_EQ(value(text, "ccdt_queue_requests"), 7);
    EXPECT_EQ(value(text, "ccdt_queue_capacity_requests"), 64);
    EXPECT_EQ(value(text, "ccdt_queue_oldest_seconds"), 1.5);
    EXPECT_EQ(value(text, "ccdt_queue_backlog_seconds"), 2.5);
    EXPECT_EQ(value(text, "ccdt_connections_open"), 0);
    EXPECT_GT(value(text, "process_resident_memory_bytes"), 1e6);
    EXPECT_GE(value(text, "process_open_fds"), 3);
    EXPECT_GE(value(text, "process_max_fds"), value(text, "process_open_fds"));
    EXPECT_NEAR(value(text, "process_start_time_seconds"), static_cast<double>(std::time(nullptr)), 60);
}

TEST(Metrics, ReportsCountsOfOtherComponents) {
    Metrics metrics("1");
    Metrics::Watched watched{
        .connections = {.open = 5, .streams = 3, .refused = 2},
        .memory_budget = 1000,
        .memory_reserved = 100,
        .decoder_restarts = 2,
        .decoder_silences = 11,
        .computing = {.crashes = 8, .overdue = 13, .restarts = 9, .silences = 12, .decoder_deaths = 3},
        .lent_threads = 4,
        .jobs = {},
        .job_runs = {},
        .redis = {},
        .job_capacity = 0,
        .job_damages = 6,
        .webhooks = {.sent = 14, .failed = 15},
        .cache = {.answers = 2, .bytes = 77, .hits = 5, .misses = 4}};
    metrics.watch([&] { return watched; });
    EXPECT_EQ(value(metrics.text({}), "ccdt_connections_open"), 5);
    EXPECT_EQ(value(metrics.text({}), "ccdt_event_streams_open"), 3);
    watched.connections = {.open = 4, .refused = 7, .refused_by_address = 1, .refused_streams = 2};
    const std::string text = metrics.text({});
    EXPECT_EQ(value(text, "ccdt_connections_open"), 4);
    EXPECT_EQ(value(text, R"(ccdt_connections_refused_total{reason="full"})"), 7);
    EXPECT_EQ(value(text, R"(ccdt_connections_refused_total{reason="address"})"), 1);
    EXPECT_EQ(value(text, R"(ccdt_connections_refused_total{reason="streams"})"), 2);
    EXPECT_EQ(value(text, "ccdt_memory_budget_bytes"), 1000);
    EXPECT_EQ(value(text, "ccdt_memory_reserved_bytes"), 100);
    EXPECT_EQ(value(text, "ccdt_computation_crashes_total"), 8);
    EXPECT_EQ(value(text, "ccdt_computations_overdue_total"), 13);
    EXPECT_EQ(value(text, "ccdt_worker_restarts_total"), 9);
    EXPECT_EQ(value(text, "ccdt_computation_threads_lent"), 4);
    EXPECT_EQ(value(text, "ccdt_decoder_deaths_total"), 3);
    EXPECT_EQ(value(text, "ccdt_decoder_restarts_total"), 2);
    EXPECT_EQ(value(text, "ccdt_decoder_silences_total"), 11);
    EXPECT_EQ(value(text, "ccdt_worker_silences_total"), 12);
    EXPECT_EQ(value(text, "ccdt_job_store_damages_total"), 6);
    EXPECT_EQ(value(text, "ccdt_webhooks_sent_total"), 14);
    EXPECT_EQ(value(text, "ccdt_webhook_failures_total"), 15);
    EXPECT_EQ(value(text, "ccdt_cache_bytes"), 77);
    EXPECT_EQ(value(text, "ccdt_cache_hits_total"), 5);
    EXPECT_EQ(value(text, "ccdt_cache_misses_total"), 4);
}

TEST(Metrics, IsThreadSafe) {
    Metrics metrics("1");
    {
        std::vector<std::jthread> threads;
        for (int i = 0; i < 4; ++i) {
            threads.emplace_back([&] {
                for (int k = 0; k < 500; ++k) metrics.add(exchange("/sample", 200 + k % 3));
            });
        }
    }
    EXPECT_EQ(value(metrics.text({}), R"(ccdt_http_request_duration_seconds_count{route="/sample"})"), 2000);
}

}  // namespace
}  // namespace ccdt::server
