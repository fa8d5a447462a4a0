// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/result_reader.h"

#include <algorithm>
#include <utility>

#include "api/output/body.h"
#include "server/jobs/job_store.h"

namespace ccdt::server {

HttpResult<std::string> ResultReader::read(const Job& job, std::size_t offset, std::size_t length) {
    // Results that are not written in pieces are stored in pieces of other sizes. They count as one piece here.
    const std::size_t size = job.result_bytes > api::Body::kMaxInMemory ? JobStore::kPiece : job.result_bytes;
    std::string part;
    while (part.size() < length) {
        const std::size_t at = offset + part.size();
        const auto text = piece(job, at / size);
        if (!text) return tl::unexpected(text.error());
        if ((*text)->size() <= at % size) return problem(500, "a piece of the result is too short");
        part.append(**text, at % size, length - part.size());
    }
    return part;
}

HttpResult<ResultReader::Text> ResultReader::piece(const Job& job, std::size_t number) {
    const bool is_whole = job.result_bytes <= api::Body::kMaxInMemory;
    if (auto kept = job.dropped ? nullptr : find(job.id, number)) return kept;
    auto text = is_whole ? jobs_.result(job.id) : jobs_.piece(job.id, number);
    if (!text) return tl::unexpected(std::move(text.error()));
    auto fresh = std::make_shared<const std::string>(*std::move(text));
    keep({job.id, number, fresh});
    return fresh;
}

ResultReader::Text ResultReader::find(const std::string& id, std::size_t number) {
    const std::lock_guard lock(mutex_);
    const auto found =
        std::ranges::find_if(pieces_, [&](const Piece& each) { return each.number == number && each.id == id; });
    if (found == pieces_.end()) return nullptr;
    std::rotate(found, found + 1, pieces_.end());
    return pieces_.back().text;
}

void ResultReader::keep(Piece piece) {
    const std::lock_guard lock(mutex_);
    bytes_ += piece.text->size();
    pieces_.push_back(std::move(piece));
    while (bytes_ > capacity_ && pieces_.size() > 1) {
        bytes_ -= pieces_.front().text->size();
        pieces_.erase(pieces_.begin());
    }
}

}  // namespace ccdt::server
