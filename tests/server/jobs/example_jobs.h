// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <string>

#include <gtest/gtest.h>

#include "server/jobs/job_store.h"

namespace ccdt::server::test {

inline const ComputeRequest kComputeRequest{"/sample", "a=b", "text/plain", "*/*",
                                            std::string("a body\0with all bytes\xff", 23)};

inline Job job_named(const std::string& id) {
    Job job;
    job.id = id;
    job.owner = "alice";
    job.client = "key alice";
    job.traceparent = "00-0af7651916cd43dd8448eb211c80319c-b7ad6b7169203331-01";
    job.cost = {1000, 0.5};
    return job;
}

inline void add(JobStore& store, Job job) {
    ASSERT_EQ(store.add(job, kComputeRequest), JobStore::Added::Accepted);
}

/// Returns the state of a job after its success with a result.
inline Job succeeded(Job job, const std::string& result) {
    job.status = JobStatus::Succeeded;
    job.media_type = "text/plain";
    job.result_bytes = result.size();
    return job;
}

/// Adds a job and finishes it. No other job must be waiting.
inline void add_finished(JobStore& store, const std::string& id, const std::string& result) {
    add(store, job_named(id));
    const auto job = store.claim(1000);
    ASSERT_TRUE(job && *job);
    ASSERT_EQ((*job)->id, id);
    const auto finished = store.finish(succeeded(**job, result), result);
    ASSERT_TRUE(finished && *finished);
}

}  // namespace ccdt::server::test
