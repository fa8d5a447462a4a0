// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/operation/parsed_request.h"

#include <optional>
#include <utility>

#include "api/analyze/analyze.h"
#include "api/analyze/surface_analyze.h"
#include "api/halftone/device_picture.h"
#include "api/halftone/halftone.h"
#include "api/halftone/halftone_cost.h"
#include "api/operation/body_kind.h"
#include "api/operation/work_progress.h"
#include "api/sample/choice/choice_formats.h"
#include "api/sample/choice/choice_parser.h"
#include "api/sample/choice/choice_sample.h"
#include "api/sample/mask/threshold_mask.h"
#include "api/sample/pixels/pixel_sample.h"
#include "api/sample/plane/sample.h"
#include "api/sample/plane/sample_cost.h"
#include "api/sample/plane/sample_parser.h"
#include "api/sample/spatial/surface_sample.h"
#include "api/sample/spatial/volume_sample.h"
#include "api/surface/surface_header.h"

namespace ccdt::api {
namespace {

std::string_view format_of(const auto& request) {
    return request.format->file.name;
}
std::string_view format_of(const SampleRequest& request) {
    return request.threshold_mask ? request.threshold_mask->format->file.name : request.output.format->file.name;
}
std::string_view format_of(const SurfaceAnalyzeRequest& /*request*/) {
    return kJson.name;
}

Cost cost_within(const auto& request, const Limits& limits) {
    if constexpr (requires { cost_of(request, limits); })
        return cost_of(request, limits);
    else
        return cost_of(request);
}

/// Returns an upper estimate of the size of an answer in bytes: if nothing better is known, the memory in which it is
/// computed.
std::size_t largest_answer_to(const auto& request, const Limits& limits) {
    if constexpr (requires { largest_answer(request, limits); })
        return largest_answer(request, limits);
    else if constexpr (requires { request.run.sites* request.format->per_site.bytes; })
        return static_cast<std::size_t>(static_cast<double>(request.run.sites) * request.format->per_site.bytes);
    else
        return cost_within(request, limits).memory;
}

bool allows_partial(const auto& request) {
    if constexpr (requires { request.on_deadline; })
        return request.on_deadline == OnStop::Partial;
    else
        return false;
}

/// Computes the answer to a request for points on a surface or in space.
Result<Answer> compute(const auto& request, const Limits& /*limits*/, const Decode& decode, const Control& control,
                       Timings& timings, BodySink* sink) {
    return run_sample3(request, decode, control, timings, sink);
}
Result<Answer> compute(const HalftoneRequest& request, const Limits& limits, const Decode& decode,
                       const Control& control, Timings& timings, BodySink* sink) {
    return run_halftone(request, limits, decode, control, timings, sink);
}
Result<Answer> compute(const DeviceRequest& request, const Limits& limits, const Decode& decode, const Control& control,
                       Timings& timings, BodySink* /*sink*/) {
    return run_device(request, limits, decode, control, timings);
}
Result<Answer> compute(const SampleRequest& request, const Limits& limits, const Decode& decode, const Control& control,
                       Timings& timings, BodySink* sink) {
    if (request.threshold_mask) return run_mask(*request.threshold_mask, control, timings);
    return run_sample(request, limits, decode, control, timings, sink);
}
Result<Answer> compute(const PixelRequest& request, const Limits& limits, const Decode& decode, const Control& control,
                       Timings& timings, BodySink* sink) {
    return run_pixels(request, limits, decode, control, timings, sink);
}
Result<Answer> compute(const ChoiceRequest& request, const Limits& limits, const Decode& decode, const Control& control,
                       Timings& timings, BodySink* sink) {
    return run_choice(request, limits, decode, control, timings, sink);
}
Result<Answer> compute(const SurfaceAnalyzeRequest& request, const Limits& /*limits*/, const Decode& decode,
                       const Control& control, Timings& timings, BodySink* /*sink*/) {
    return run_surface_analyze(request, decode, control, timings);
}
Result<Answer> compute(const AnalyzeRequest& request, const Limits& /*limits*/, const Decode& /*decode*/,
                       const Control& control, Timings& timings, BodySink* /*sink*/) {
    return run_analyze(request, control, timings);
}

/// A parsed request of one type. The overloaded functions above implement its members for each type.
template <class Request>
class Parsed : public ParsedRequest {
public:
    Parsed(Request request, const Limits& limits) : request_(std::move(request)), limits_(limits) {}

    std::string_view format() const override { return format_of(request_); }

    Cost cost() const override {
        const auto computing = cost_within(request_, limits_);
        return {size_of(request_) + computing.memory, computing.seconds, computing.answer};
    }

    std::size_t largest_answer() const override { return largest_answer_to(request_, limits_); }

    bool accepts_partial() const override { return allows_partial(request_); }

    Result<Answer> run(const Decode& decode, const Control& control, Timings& timings, BodySink* sink) const override {
        WorkProgress progress(control, cost_within(request_, limits_));
        return compute(request_, limits_, progress.observe(decode), progress.control(), timings, sink);
    }

private:
    const Request request_;
    const Limits limits_;
};

/// Reads a request for a halftone whose body is the file of a picture.
HalftoneInput read_picture(std::string_view body, const std::vector<TextOption>& options, const Limits& limits) {
    if (body.empty() || (recognise_image(body) && !is_stripped(body))) return read_halftone(body, options, limits);
    return read_halftone(
        failure(ErrorCode::Unsupported, "this is " + kind_of_body(body) + std::string(kPictureFormats)), options);
}

template <class Request>
Result<ParsedPointer> pack(Result<Request> request, const Limits& limits) {
    if (!request) return tl::unexpected(std::move(request.error()));
    return std::make_unique<const Parsed<Request>>(*std::move(request), limits);
}

}  // namespace

Result<ParsedPointer> parse_halftone_request(std::string_view body, HalftoneBody kind,
                                             const std::vector<TextOption>& options, std::string_view accept,
                                             const Limits& limits) {
    constexpr std::string_view kAccepted =
        "pictures (PNG, JPEG, WebP, TIFF, GIF, BMP, AVIF and HEIC), and JSON with the member image";
    const auto input =
        kind == HalftoneBody::Json ? read_halftone_json(body, options, limits) : read_picture(body, options, limits);
    if (!input) return not_json(body, input.error(), kAccepted);
    const std::string_view document = input->document ? kind_of_json(input->document->root()) : "";
    if (!document.empty()) return wrong_body(document, kAccepted);
    if (input->has("device")) return pack(parse_device(*input, accept, limits), limits);
    return pack(parse_halftone(*input, accept, limits), limits);
}

Result<ParsedPointer> parse_sample_request(std::string_view body, const std::vector<TextOption>& options,
                                           std::string_view accept, const Limits& limits, std::string_view media_type) {
    if (asks_for_choice(options)) return pack(parse_choice(body, options, accept, limits), limits);
    if (is_voxel_file(body)) return pack(parse_volume(open_voxels(body, limits), options, accept, limits), limits);
    if (auto file = open_surface(body, media_type, limits.max_faces, limits.max_pixels)) {
        if (asks_for_solid(options)) return pack(parse_solid(*std::move(file), options, accept, limits), limits);
        return pack(parse_surface(*std::move(file), options, accept, limits), limits);
    }
    const auto document = parse_sample_document(body);
    if (!document) return tl::unexpected(document.error());
    const JsonValue root = document->root();
    if (asks_for_choice(root)) return pack(parse_choice(root, options, accept, limits), limits);
    if (asks_for_pixels(root)) return pack(parse_pixels(root, options, accept, limits), limits);
    if (asks_for_volume(root)) return pack(parse_volume(root, options, accept, limits), limits);
    return pack(parse_sample(root, options, accept, limits), limits);
}

Result<ParsedPointer> parse_analyze_request(std::string_view body, const std::vector<TextOption>& options,
                                            std::string_view accept, const Limits& limits,
                                            std::string_view media_type) {
    if (auto file = open_surface(body, media_type, limits.max_faces, 0))
        return pack(parse_surface_analyze(*std::move(file), options, accept, limits), limits);
    if (!options.empty())
        return failure(ErrorCode::Malformed, "the body is not a mesh, so the options must be members of its JSON",
                       options.front().name);
    auto request = parse_analyze(body, accept, limits);
    if (request) return pack(std::move(request), limits);
    constexpr std::string_view kAccepted = "JSON with the member points or sets, and a mesh with the option points";
    if (const auto document = JsonDocument::parse(body)) {
        const auto kind = kind_of_json(document->root());
        return kind.empty() ? tl::unexpected(request.error()) : wrong_body(kind, kAccepted);
    }
    return not_json(body, request.error(), kAccepted);
}

}  // namespace ccdt::api
