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
    job.cost = {1000, 0.5};
    job.created = time_now();
    return job;
}

/// Adds a job and finishes it.
inline void add_finished(JobStore& store, const std::string& id, Time finished, const std::string& result) {
    Job job = job_named(id);
    ASSERT_TRUE(store.add(job, kComputeRequest));
    job.status = JobStatus::Succeeded;
    job.finished = finished;
    job.media_type = "text/plain";
    job.result_bytes = result.size();
    ASSERT_TRUE(store.finish(job, result));
}

}  // namespace ccdt::server::test
