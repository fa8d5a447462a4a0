// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/requests/compute.h"

#include <chrono>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "server/http/compression.h"
#include "server/requests/operation.h"

namespace ccdt::server {
namespace {

/// Compresses a body, unless a stop was requested: partial answers are sent without delay.
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

/// Compresses the pieces of a text and passes them to another sink. Other media types are not compressed.
class CompressingSink : public api::BodySink {
public:
    explicit CompressingSink(api::BodySink& next) : next_(next) {}

    Result<void> begin(const api::Answer& head) override {
        if (!is_compressible(head.media_type)) return next_.begin(head);
        compressor_.emplace();
        api::Answer compressed = head;
        compressed.coding = "gzip";
        return next_.begin(compressed);
    }

    Result<void> write(std::string_view piece) override {
        return compressor_ ? pass_on(piece, false) : next_.write(piece);
    }

    /// Ends a body for which begin() was called.
    Result<void> finish() { return compressor_ ? pass_on({}, true) : Result<void>(); }

private:
    Result<void> pass_on(std::string_view piece, bool last) {
        compressed_.clear();
        compressor_->add(piece, last, compressed_);
        return compressed_.empty() ? Result<void>() : next_.write(compressed_);
    }

    api::BodySink& next_;
    std::optional<Gzip> compressor_;
    std::string compressed_;
};

}  // namespace

Result<api::Answer> compute_here(const ComputeRequest& request, const Delivery& delivery, const api::Limits& limits,
                                 const api::Decode& decode, const Control& control, api::Timings& timings) {
    const Operation* const operation = find_operation(request.path);
    if (operation == nullptr) return failure(ErrorCode::Internal, "nothing is computed at " + request.path);
    const auto parsed = operation->parse(request, limits);
    if (!parsed) return tl::unexpected(parsed.error());
    std::optional<CompressingSink> compressing;
    if (delivery.compressed && delivery.sink != nullptr) compressing.emplace(*delivery.sink);
    auto answer = (*parsed)->run(decode, control, timings, compressing ? &*compressing : delivery.sink);
    if (!answer || !delivery.compressed) return answer;
    if (!answer->streamed) {
        compress(*answer, control.stop, timings);
    } else if (auto finished = compressing->finish(); !finished) {
        return tl::unexpected(finished.error());
    }
    return answer;
}

}  // namespace ccdt::server
