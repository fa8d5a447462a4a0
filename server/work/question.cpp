#include "server/work/question.h"

#include <algorithm>
#include <iterator>
#include <optional>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "api/cost.h"
#include "server/http/http.h"
#include "server/http/multipart.h"

namespace ccdt::server {
namespace {

constexpr std::string_view kHalftone = "/halftone";
constexpr std::string_view kForm = "multipart/form-data";

/// Longer JSON is read by a worker, and so are longer forms.
constexpr std::size_t kQuickToParse = 8'192;
constexpr std::size_t kQuickToSearch = 1 << 20;

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
Result<std::string_view> read_form(const Question& question, std::vector<api::TextOption>& options) {
    const std::string_view body = question.body;
    const auto parts = parse_multipart(body, question.content_type);
    if (!parts) return failure(ErrorCode::Malformed, parts.error().error.message);
    std::optional<std::string_view> picture;
    for (const FormPart& part : *parts) {
        if (part.name != "image" && part.name != "file") {
            options.push_back({part.name, std::string(part.content(body))});
        } else if (!picture) {
            picture = part.content(body);
        } else {
            return failure(ErrorCode::Malformed, "the form holds more than one picture", "image");
        }
    }
    if (!picture) return failure(ErrorCode::Malformed, "the form has no part `image`", "image");
    return *picture;
}

Result<api::HalftoneRequest> understand_halftone(const Question& question, const api::Limits& limits) {
    const std::string type = media_type(question.content_type);
    auto options = parse_query(question.query);
    if (is_json(type)) return api::parse_halftone_json(question.body, options, question.accept, limits);
    const auto image =
        type == kForm ? read_form(question, options) : Result<std::string_view>(std::string_view(question.body));
    if (!image) return tl::unexpected(image.error());
    return api::parse_halftone(*image, options, question.accept, limits);
}

bool reads_json(const Question& question) {
    return question.path != kHalftone || is_json(media_type(question.content_type));
}

}  // namespace

Result<void> check(const Question& question) {
    if (question.path == kHalftone) return {};
    const std::string type = media_type(question.content_type);
    if (!may_hold_json(type)) return failure(ErrorCode::Unsupported, "the body must be application/json, not " + type);
    if (!question.query.empty())
        return failure(ErrorCode::Malformed, "the options of this path are members of the JSON body");
    return {};
}

bool is_quickly_understood(const Question& question) {
    if (reads_json(question)) return question.body.size() <= kQuickToParse;
    return media_type(question.content_type) != kForm || question.body.size() <= kQuickToSearch;
}

api::Cost cost_of_understanding(const Question& question) {
    if (reads_json(question)) return api::cost_of_parsing(question.body);
    constexpr double kSecondsPerByte = 1e-9;
    return {0, static_cast<double>(question.body.size()) * kSecondsPerByte};
}

Result<Understood> understand(const Question& question, const api::Limits& limits) {
    const auto understood = [](auto parsed) { return Understood(std::move(parsed)); };
    if (question.path == kHalftone) return understand_halftone(question, limits).map(understood);
    if (question.path == "/sample") return api::parse_sample(question.body, question.accept, limits).map(understood);
    if (question.path == "/analyze") return api::parse_analyze(question.body, question.accept, limits).map(understood);
    return failure(ErrorCode::Internal, "nothing is computed at " + question.path);
}

api::Cost cost_of_answering(const Question& question, const Understood& asked, const api::Limits& limits) {
    const auto reading = cost_of_understanding(question);
    const auto [computing, held] = std::visit(
        [&](const auto& request) {
            if constexpr (std::is_same_v<std::decay_t<decltype(request)>, api::AnalyzeRequest>)
                return std::pair(api::cost_of(request), api::size_of(request));
            else
                return std::pair(api::cost_of(request, limits), api::size_of(request));
        },
        asked);
    return {question.body.size() + std::max(reading.memory, held + computing.memory),
            reading.seconds + computing.seconds};
}

}  // namespace ccdt::server
