// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <memory>
#include <string_view>

#include "api/image/image_codec.h"
#include "api/output/body.h"
#include "api/run/options.h"
#include "core/ccdt/ccdt.h"
#include "core/result.h"
#include "server/work/compute_request.h"

namespace ccdt::server {

/// A parsed, valid request. May point into the body that was parsed.
class ParsedRequest {
public:
    virtual ~ParsedRequest() = default;

    /// Cost of computing the answer, including the memory of the request itself.
    virtual api::Cost cost() const = 0;

    /// Whether the client accepts a partial answer at the deadline.
    virtual bool accepts_partial() const = 0;

    /// Computes the answer: see Compute.
    virtual Result<api::Answer> run(const api::Decode& decode, const Control& control, api::Timings& timings,
                                    api::BodySink* sink) const = 0;
};
using ParsedPointer = std::unique_ptr<const ParsedRequest>;

/// A row of the table of operations. All differences between operations are members here, or functions of the
/// ParsedRequest that `parse` returns.
struct Operation {
    std::string_view path;  ///< path of the POST route
    bool takes_pictures;    ///< accepts pictures as bodies and in forms; otherwise the body is JSON
    bool takes_shapefiles;  ///< accepts zipped shapefiles as bodies and converts them to JSON
    bool takes_query;       ///< accepts options in the query
    /// Name of the form field that becomes the body; a field named `file` is accepted, too. Empty: forms are refused.
    std::string_view form_part;

    /// Errors: those of the parser of the operation.
    Result<ParsedPointer> (*parse)(const ComputeRequest& request, const api::Limits& limits);
};

Result<ParsedPointer> parse_halftone(const ComputeRequest& request, const api::Limits& limits);
Result<ParsedPointer> parse_sample(const ComputeRequest& request, const api::Limits& limits);
Result<ParsedPointer> parse_analyze(const ComputeRequest& request, const api::Limits& limits);

inline constexpr auto kOperations = std::to_array<Operation>({
    {"/halftone", true, false, true, "image", parse_halftone},
    {"/sample", false, true, true, "map", parse_sample},
    {"/analyze", false, false, false, "", parse_analyze},
});

/// Finds the operation of a path; null if there is none.
constexpr const Operation* find_operation(std::string_view path) {
    for (const Operation& operation : kOperations) {
        if (operation.path == path) return &operation;
    }
    return nullptr;
}

/// Checks the content type and the presence of a query, before the body is read. Errors: Unsupported, Malformed.
Result<void> check(const Operation& operation, const ComputeRequest& request);

/// Whether the body is a zipped shapefile. Only the decoder process may read such a body.
bool holds_shapefile(const Operation& operation, const ComputeRequest& request);

/// Whether the thread of a connection may parse the request without a noticeable delay: JSON up to 8 KiB, or a picture.
bool is_quickly_parsed(const Operation& operation, const ComputeRequest& request);

/// Estimates the cost of parsing.
api::Cost cost_of_parsing(const Operation& operation, const ComputeRequest& request);

/// Estimates the cost of parsing a copy of the request and computing the answer.
api::Cost cost_of_answering(const Operation& operation, const ComputeRequest& request, const ParsedRequest& parsed);

}  // namespace ccdt::server
