#include "server/work/computation.h"

#include <chrono>
#include <utility>
#include <variant>

#include "server/http/compression.h"

namespace ccdt::server {
namespace {

/// Finds what computes the answer to each kind of request.
struct Run {
    const api::Limits& limits;
    const api::Decode& decode;
    const Control& control;
    api::Timings& timings;

    Result<api::Answer> operator()(const api::HalftoneRequest& request) const {
        return api::run_halftone(request, limits, decode, control, timings);
    }
    Result<api::Answer> operator()(const api::SampleRequest& request) const {
        return api::run_sample(request, limits, decode, control, timings);
    }
    Result<api::Answer> operator()(const api::AnalyzeRequest& request) const {
        return api::run_analyze(request, control, timings);
    }
};

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

Result<api::Answer> compute_here(const Question& question, const Manner& manner, const api::Limits& limits,
                                 const api::Decode& decode, const Control& control, api::Timings& timings) {
    const auto asked = understand(question, limits);
    if (!asked) return tl::unexpected(asked.error());
    auto answer = std::visit(Run{limits, decode, control, timings}, *asked);
    if (answer && manner.compressed) compress(*answer, control.stop, timings);
    return answer;
}

}  // namespace ccdt::server
