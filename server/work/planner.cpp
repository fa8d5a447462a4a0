#include "server/work/planner.h"

#include <algorithm>
#include <iterator>
#include <memory>
#include <utility>
#include <vector>

#include "api/cost.h"
#include "server/http/http.h"
#include "server/http/multipart.h"

namespace ccdt::server {
namespace {

constexpr std::string_view kHalftone = "/halftone";

/// Longer JSON is read by a worker.
constexpr std::size_t kQuickToParse = 8'192;

bool is_json(std::string_view type) {
    return type == "application/json" || (type.starts_with("application/") && type.ends_with("+json"));
}

/// Types under which programs send JSON without saying so.
bool may_hold_json(std::string_view type) {
    constexpr std::string_view kUnspecific[] = {"", "text/plain", "application/octet-stream",
                                                "application/x-www-form-urlencoded"};
    return is_json(type) || std::ranges::find(kUnspecific, type) != std::end(kUnspecific);
}

/// The picture of a form; its other fields are added to the options.
Result<std::string> read_form(std::string body, std::string_view content_type, std::vector<api::TextOption>& options) {
    const auto parts = parse_multipart(body, content_type);
    if (!parts) return failure(ErrorCode::Malformed, parts.error().detail);
    const FormPart* picture = nullptr;
    for (const FormPart& part : *parts) {
        if (part.name != "image" && part.name != "file") {
            options.push_back({part.name, std::string(part.content(body))});
        } else if (picture == nullptr) {
            picture = &part;
        } else {
            return failure(ErrorCode::Malformed, "the form holds more than one picture", "image");
        }
    }
    if (picture == nullptr) return failure(ErrorCode::Malformed, "the form has no part `image`", "image");
    // In place: the picture may be as large as the body.
    body.resize(picture->begin + picture->size);
    body.erase(0, picture->begin);
    return body;
}

}  // namespace

Result<void> Planner::check(const Question& question) {
    if (question.path == kHalftone) return {};
    const std::string type = media_type(question.content_type);
    if (!may_hold_json(type)) return failure(ErrorCode::Unsupported, "the body must be application/json, not " + type);
    if (!question.query.empty())
        return failure(ErrorCode::Malformed, "the options of this path are members of the JSON body");
    return {};
}

bool Planner::is_quick(const Question& question) {
    const bool reads_json = question.path != kHalftone || is_json(media_type(question.content_type));
    return !reads_json || question.body.size() <= kQuickToParse;
}

api::Cost Planner::cost_of_planning(const Question& question) {
    return api::cost_of_parsing(question.body);
}

Result<Plan> Planner::plan(Question question) const {
    const auto plan_it = [this](auto parsed) { return this->plan_for(std::move(parsed)); };
    if (question.path == kHalftone) return plan_halftone(std::move(question));
    if (question.path == "/sample") return api::parse_sample(question.body, question.accept, limits_).map(plan_it);
    if (question.path == "/analyze") return api::parse_analyze(question.body, question.accept, limits_).map(plan_it);
    return failure(ErrorCode::Internal, "nothing is computed at " + question.path);
}

Result<Plan> Planner::plan_halftone(Question question) const {
    const auto plan_it = [this](api::HalftoneRequest parsed) { return plan_for(std::move(parsed)); };
    const std::string type = media_type(question.content_type);
    auto options = parse_query(question.query);
    if (is_json(type)) return api::parse_halftone_json(question.body, options, question.accept, limits_).map(plan_it);
    Result<std::string> image = std::move(question.body);
    if (type == "multipart/form-data") image = read_form(*std::move(image), question.content_type, options);
    if (!image) return tl::unexpected(std::move(image.error()));
    return api::parse_halftone(*std::move(image), options, question.accept, limits_).map(plan_it);
}

/// The request is shared because functions are copied, and pictures should not be.
template <class Parsed, class Run>
Plan Planner::plan_for(Parsed request, const api::Cost& cost, Run run) {
    const std::size_t size = api::size_of(request);
    return {cost, size,
            [run = std::move(run), shared = std::make_shared<const Parsed>(std::move(request))](
                const Control& control, api::Timings& timings) { return run(*shared, control, timings); }};
}

Plan Planner::plan_for(api::HalftoneRequest request) const {
    const auto cost = api::cost_of(request, limits_);
    return plan_for(std::move(request), cost, [this](const auto& parsed, const Control& control, auto& timings) {
        return api::run_halftone(parsed, limits_, decode_, control, timings);
    });
}

Plan Planner::plan_for(api::SampleRequest request) const {
    const auto cost = api::cost_of(request, limits_);
    return plan_for(std::move(request), cost, [this](const auto& parsed, const Control& control, auto& timings) {
        return api::run_sample(parsed, limits_, decode_, control, timings);
    });
}

Plan Planner::plan_for(api::AnalyzeRequest request) {
    const auto cost = api::cost_of(request);
    return plan_for(std::move(request), cost, api::run_analyze);
}

}  // namespace ccdt::server
