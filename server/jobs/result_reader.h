// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "server/http/problem.h"
#include "server/jobs/job.h"
#include "server/jobs/job_service.h"

namespace ccdt::server {

/// Reads parts of results. Keeps the pieces that were used last, because clients of tiles read many small parts of the
/// same result. Thread-safe.
class ResultReader {
public:
    /// @param jobs      must outlive this object
    /// @param capacity  bytes of pieces to keep; the last piece is kept even if it is larger
    ResultReader(JobService& jobs, std::size_t capacity) : jobs_(jobs), capacity_(capacity) {}

    /// Reads a part of the result of a job that has succeeded.
    /// @param job     as found now, so that results of removed jobs are not read
    /// @param offset  the part must lie within the result
    /// Problems: those of JobService::piece().
    HttpResult<std::string> read(const Job& job, std::size_t offset, std::size_t length);

private:
    using Text = std::shared_ptr<const std::string>;
    struct Piece {
        std::string id;
        std::size_t number;
        Text text;
    };

    HttpResult<Text> piece(const Job& job, std::size_t number);
    Text find(const std::string& id, std::size_t number);
    void keep(Piece piece);

    JobService& jobs_;
    const std::size_t capacity_;

    std::mutex mutex_;           ///< guards the members below
    std::vector<Piece> pieces_;  ///< the piece that was used last is the last one
    std::size_t bytes_ = 0;      ///< of all pieces
};

}  // namespace ccdt::server
