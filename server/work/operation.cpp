// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/work/operation.h"

#include <algorithm>
#include <string>
#include <utility>

#include "api/analyze/analyze.h"
#include "api/halftone/device_picture.h"
#include "api/halftone/halftone.h"
#include "api/halftone/halftone_cost.h"
#include "api/map/shapefile_reader.h"
#include "api/sample/pixel_sample.h"
#include "api/sample/sample.h"
#include "api/sample/sample_cost.h"
#include "api/sample/sample_parser.h"
#include "api/sample/threshold_mask.h"
#include "api/text/text.h"
#include "server/http/http.h"

namespace ccdt::server {
namespace {

/// Maximum size of JSON [bytes] that a connection's thread parses. Workers parse longer texts.
constexpr std::size_t kQuickToParse = 8'192;

bool is_json(std::string_view type) {
    return type == "application/json" || (type.starts_with("application/") && type.ends_with("+json"));
}

bool is_zip(std::string_view type) {
    return type == "application/zip" || type == "application/x-zip-compressed";
}

/// Whether a body of this content type may be JSON: the type is JSON, or a default of client programs.
bool may_hold_json(std::string_view type) {
    constexpr auto kUnspecific = std::to_array<std::string_view>(
        {"", "text/plain", "application/octet-stream", "application/x-www-form-urlencoded"});
    return is_json(type) || std::ranges::find(kUnspecific, type) != kUnspecific.end();
}

/// Whether the body is JSON rather than a picture. The content type decides. If the type is a default of client
/// programs, the first character decides: no picture begins with `{`.
bool holds_json(const ComputeRequest& request) {
    const std::string type = media_type(request.content_type);
    return is_json(type) || (may_hold_json(type) && api::trim(request.body, " \t\r\n").starts_with('{'));
}

bool reads_json(const Operation& operation, const ComputeRequest& request) {
    return !operation.takes_pictures || holds_json(request);
}

api::Cost cost_of(const api::AnalyzeRequest& request, const api::Limits& /*limits*/) {
    return api::cost_of(request);
}
api::Cost cost_of(const auto& request, const api::Limits& limits) {
    return api::cost_of(request, limits);
}

bool accepts_partial(const api::AnalyzeRequest& /*request*/) {
    return false;
}
bool accepts_partial(const auto& request) {
    return request.on_deadline == api::OnStop::Partial;
}

Result<api::Answer> compute(const api::HalftoneRequest& request, const api::Limits& limits, const api::Decode& decode,
                            const Control& control, api::Timings& timings, api::BodySink* sink) {
    return api::run_halftone(request, limits, decode, control, timings, sink);
}
Result<api::Answer> compute(const api::DeviceRequest& request, const api::Limits& limits, const api::Decode& decode,
                            const Control& control, api::Timings& timings, api::BodySink* /*sink*/) {
    return api::run_device(request, limits, decode, control, timings);
}
Result<api::Answer> compute(const api::SampleRequest& request, const api::Limits& limits, const api::Decode& decode,
                            const Control& control, api::Timings& timings, api::BodySink* sink) {
    if (request.threshold_mask) return api::run_mask(*request.threshold_mask, control, timings);
    return api::run_sample(request, limits, decode, control, timings, sink);
}
Result<api::Answer> compute(const api::PixelRequest& request, const api::Limits& limits, const api::Decode& decode,
                            const Control& control, api::Timings& timings, api::BodySink* sink) {
    return api::run_pixels(request, limits, decode, control, timings, sink);
}
Result<api::Answer> compute(const api::AnalyzeRequest& request, const api::Limits& /*limits*/,
                            const api::Decode& /*decode*/, const Control& control, api::Timings& timings,
                            api::BodySink* /*sink*/) {
    return api::run_analyze(request, control, timings);
}

/// A parsed request of one of api's request types. The overloaded functions above implement its members for each type.
template <class Request>
class Parsed : public ParsedRequest {
public:
    Parsed(Request request, const api::Limits& limits) : request_(std::move(request)), limits_(limits) {}

    api::Cost cost() const override {
        const auto computing = server::cost_of(request_, limits_);
        return {api::size_of(request_) + computing.memory, computing.seconds, computing.answer};
    }

    bool accepts_partial() const override { return server::accepts_partial(request_); }

    Result<api::Answer> run(const api::Decode& decode, const Control& control, api::Timings& timings,
                            api::BodySink* sink) const override {
        return compute(request_, limits_, decode, control, timings, sink);
    }

private:
    const Request request_;
    const api::Limits limits_;
};

template <class Request>
Result<ParsedPointer> pack(Result<Request> request, const api::Limits& limits) {
    if (!request) return tl::unexpected(std::move(request.error()));
    return std::make_unique<const Parsed<Request>>(*std::move(request), limits);
}

}  // namespace

Result<ParsedPointer> parse_halftone(const ComputeRequest& request, const api::Limits& limits) {
    const auto options = parse_query(request.query);
    const auto input = holds_json(request) ? api::read_halftone_json(request.body, options, limits)
                                           : api::read_halftone(request.body, options, limits);
    if (!input) return tl::unexpected(input.error());
    if (input->has("device")) return pack(api::parse_device(*input, request.accept, limits), limits);
    return pack(api::parse_halftone(*input, request.accept, limits), limits);
}

Result<ParsedPointer> parse_sample(const ComputeRequest& request, const api::Limits& limits) {
    const auto document = api::JsonDocument::parse(request.body);
    if (!document) return tl::unexpected(document.error());
    const api::JsonValue root = document->root();
    const auto options = parse_query(request.query);
    if (api::asks_for_pixels(root)) return pack(api::parse_pixels(root, options, request.accept, limits), limits);
    return pack(api::parse_sample(root, options, request.accept, limits), limits);
}

Result<ParsedPointer> parse_analyze(const ComputeRequest& request, const api::Limits& limits) {
    return pack(api::parse_analyze(request.body, request.accept, limits), limits);
}

Result<void> check(const Operation& operation, const ComputeRequest& request) {
    if (operation.takes_pictures) return {};
    const std::string type = media_type(request.content_type);
    const bool is_taken = may_hold_json(type) || (operation.takes_shapefiles && is_zip(type)) ||
                          (!operation.form_part.empty() && type == "multipart/form-data");
    const std::string others = operation.takes_shapefiles ? ", application/zip or multipart/form-data" : "";
    if (!is_taken)
        return failure(ErrorCode::Unsupported, "the body must be application/json" + others + ", not " + type);
    if (!operation.takes_query && !request.query.empty())
        return failure(ErrorCode::Malformed, "the options of this path are members of the JSON body");
    return {};
}

bool holds_shapefile(const Operation& operation, const ComputeRequest& request) {
    if (!operation.takes_shapefiles) return false;
    const std::string type = media_type(request.content_type);
    return is_zip(type) || (may_hold_json(type) && request.body.starts_with(api::kZipSignature));
}

bool is_quickly_parsed(const Operation& operation, const ComputeRequest& request) {
    return !reads_json(operation, request) || request.body.size() <= kQuickToParse;
}

api::Cost cost_of_parsing(const Operation& operation, const ComputeRequest& request) {
    if (reads_json(operation, request)) return api::cost_of_parsing(request.body);
    constexpr double kSecondsPerByte = 1e-9;
    return {0, static_cast<double>(request.body.size()) * kSecondsPerByte};
}

api::Cost cost_of_answering(const Operation& operation, const ComputeRequest& request, const ParsedRequest& parsed) {
    const auto parsing = cost_of_parsing(operation, request);
    const auto computing = parsed.cost();
    return {request.body.size() + std::max(parsing.memory, computing.memory), parsing.seconds + computing.seconds,
            computing.answer};
}

}  // namespace ccdt::server
