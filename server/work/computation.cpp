#include "server/work/computation.h"

#include <chrono>
#include <utility>

#include "server/http/compression.h"
#include "server/work/operation.h"

namespace ccdt::server {
namespace {

/// Leaves an answer as it is if a stop has come: what there is by a deadline goes out at once.
void compress(api::Answer& answer, const std::stop_token& stop, api::Timings& timings) {
    if (!is_worth_compressing(answer.media_type, answer.body)) return;
    const auto start = std::chrono::steady_clock::now();
    if (auto compressed = gzip(answer.body, stop)) {
        answer.body = std::move(*compressed);
        answer.coding = "gzip";
    }
    const std::chrono::duration<double, std::milli> taken = std::chrono::steady_clock::now() - start;
    timings.encode += taken.count();
}

}  // namespace

Result<api::Answer> compute_here(const ComputeRequest& request, const Delivery& delivery, const api::Limits& limits,
                                 const api::Decode& decode, const Control& control, api::Timings& timings) {
    const Operation* const operation = find_operation(request.path);
    if (operation == nullptr) return failure(ErrorCode::Internal, "nothing is computed at " + request.path);
    const auto parsed = operation->parse(request, limits);
    if (!parsed) return tl::unexpected(parsed.error());
    auto answer = (*parsed)->run(decode, control, timings);
    if (answer && delivery.compressed) compress(*answer, control.stop, timings);
    return answer;
}

}  // namespace ccdt::server
