#pragma once

#include <string>
#include <variant>

#include "api/analyze.h"
#include "api/halftone.h"
#include "api/options.h"
#include "api/sample.h"
#include "core/result.h"

namespace ccdt::server {

/// All of a request that its answer depends on.
struct Question {
    std::string path;
    std::string query;         ///< as sent
    std::string content_type;  ///< as sent, like the next
    std::string accept;
    std::string body;
};

/// What is asked, read and found right. May point into the question's body.
using Understood = std::variant<api::HalftoneRequest, api::SampleRequest, api::AnalyzeRequest>;

/// Errors: those that a request has whatever its body.
Result<void> check(const Question& question);

/// Whether to understand it takes no longer than the thread of a connection should.
bool is_quickly_understood(const Question& question);

/// Of `understand`.
api::Cost cost_of_understanding(const Question& question);

/// Errors: those of the path's parser.
Result<Understood> understand(const Question& question, const api::Limits& limits);

/// Of computing the answer where there is nothing but a copy of the question, which is understood again there.
api::Cost cost_of_answering(const Question& question, const Understood& asked, const api::Limits& limits);

}  // namespace ccdt::server
