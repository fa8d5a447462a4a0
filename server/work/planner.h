#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <string_view>

#include "api/analyze.h"
#include "api/halftone.h"
#include "api/image/image_codec.h"
#include "api/options.h"
#include "api/sample.h"
#include "core/ccdt/ccdt.h"
#include "core/result.h"

namespace ccdt::server {

/// What a worker does.
template <class T>
using Task = std::function<Result<T>(const Control&, api::Timings&)>;

/// All of a request that its answer depends on.
struct Question {
    std::string path;
    std::string query;         ///< as sent
    std::string content_type;  ///< as sent, like the next
    std::string accept;
    std::string body;
};

/// A request that is understood.
struct Plan {
    api::Cost cost;
    std::size_t size = 0;  ///< bytes that it holds
    Task<api::Answer> work;
};

/// Understands what is asked of the paths that compute. May be used from any thread; must outlive its plans' work.
class Planner {
public:
    Planner(const api::Limits& limits, api::Decode decode) : limits_(limits), decode_(std::move(decode)) {}

    /// Errors: those that a request has whatever its body.
    static Result<void> check(const Question& question);

    /// Whether `plan` takes no longer than the thread of a connection should.
    static bool is_quick(const Question& question);

    /// Of `plan`, if it is not quick.
    static api::Cost cost_of_planning(const Question& question);

    /// Errors: those of the path's parser.
    Result<Plan> plan(Question question) const;

private:
    Result<Plan> plan_halftone(Question question) const;
    template <class Parsed, class Run>
    static Plan plan_for(Parsed request, const api::Cost& cost, Run run);
    Plan plan_for(api::HalftoneRequest request) const;
    Plan plan_for(api::SampleRequest request) const;
    static Plan plan_for(api::AnalyzeRequest request);

    const api::Limits limits_;
    const api::Decode decode_;
};

}  // namespace ccdt::server
