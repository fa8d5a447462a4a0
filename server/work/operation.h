#pragma once

#include <array>
#include <memory>
#include <string_view>

#include "api/image/image_codec.h"
#include "api/options.h"
#include "core/ccdt/ccdt.h"
#include "core/result.h"
#include "server/work/question.h"

namespace ccdt::server {

/// A request that was read and found right. May point into the body that it was read from.
class ParsedRequest {
public:
    virtual ~ParsedRequest() = default;

    /// Of computing the answer, with what the request itself holds.
    virtual api::Cost cost() const = 0;

    /// Computes the answer: see Compute.
    virtual Result<api::Answer> run(const api::Decode& decode, const Control& control, api::Timings& timings) const = 0;
};
using ParsedPointer = std::unique_ptr<const ParsedRequest>;

/// A row of the table of what the server computes. All that differs between them is here, or in what `parse` makes.
struct Operation {
    std::string_view path;  ///< that it is POSTed to
    bool takes_pictures;    ///< as bodies and in forms, with options in the query; else the body is JSON

    /// Errors: those of the path's parser.
    Result<ParsedPointer> (*parse)(const Question& question, const api::Limits& limits);
};

Result<ParsedPointer> parse_halftone(const Question& question, const api::Limits& limits);
Result<ParsedPointer> parse_sample(const Question& question, const api::Limits& limits);
Result<ParsedPointer> parse_analyze(const Question& question, const api::Limits& limits);

inline constexpr auto kOperations = std::to_array<Operation>({
    {"/halftone", true, parse_halftone},
    {"/sample", false, parse_sample},
    {"/analyze", false, parse_analyze},
});

/// Finds the row of a path; null if there is none.
const Operation* find_operation(std::string_view path);

/// Errors: those that a request has whatever its body.
Result<void> check(const Operation& operation, const Question& question);

/// Whether to parse it takes no longer than the thread of a connection should.
bool is_quickly_parsed(const Operation& operation, const Question& question);

/// What parsing takes.
api::Cost cost_of_parsing(const Operation& operation, const Question& question);

/// What computing the answer takes where there is nothing but a copy of the question, which is parsed again there.
api::Cost cost_of_answering(const Operation& operation, const Question& question, const ParsedRequest& parsed);

}  // namespace ccdt::server
