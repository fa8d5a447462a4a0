// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/job_store.h"

#include <utility>

#include "server/requests/digest.h"

namespace ccdt::server {

Result<std::optional<std::string>> JobStore::result(const std::string& id) {
    const auto job = find(id);
    if (!job) return tl::unexpected(job.error());
    auto all = piece(id, 0);
    if (!*job || !all || !*all) return all;
    std::string& body = **all;
    for (std::size_t number = 1; body.size() < (*job)->result_bytes; ++number) {
        auto next = piece(id, number);
        if (!next || !*next) return next;
        body += **next;
    }
    return all;
}

std::string digest_of_piece(std::string_view id, std::size_t number, std::string_view piece) {
    Digest digest;
    digest.add(id);
    digest.add(std::to_string(number));
    digest.add(piece);
    return digest.finish();
}

}  // namespace ccdt::server
