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

/// A request that was read and found right. May point into the body that it was read from.
class ParsedRequest {
public:
    virtual ~ParsedRequest() = default;

    /// Cost of computing the answer, with what the request itself holds.
    virtual api::Cost cost() const = 0;

    /// Whether the client asks for a partial answer once the deadline has passed.
    virtual bool accepts_partial() const = 0;

    /// Computes the answer: see Compute.
    virtual Result<api::Answer> run(const api::Decode& decode, const Control& control, api::Timings& timings,
                                    api::BodyTaker* taker) const = 0;
};
using ParsedPointer = std::unique_ptr<const ParsedRequest>;

/// A row of the table of what the server computes. All that differs between them is here, or in what `parse` makes.
struct Operation {
    std::string_view path;  ///< that it is POSTed to
    bool takes_pictures;    ///< as bodies; else the body is JSON
    bool takes_shapefiles;  ///< zipped, as bodies, which become JSON
    bool takes_query;       ///< has options in the query
    /// Part of a form that becomes the body, as `file` does; empty: no forms are taken.
    std::string_view form_part;

    /// Errors: those of the path's parser.
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

/// Finds the row of a path; null if there is none.
constexpr const Operation* find_operation(std::string_view path) {
    for (const Operation& operation : kOperations) {
        if (operation.path == path) return &operation;
    }
    return nullptr;
}

/// Checks all but the body. Errors: those that a request has whatever its body.
Result<void> check(const Operation& operation, const ComputeRequest& request);

/// Tells whether the body is a zipped shapefile, which only the decoder reads.
bool holds_shapefile(const Operation& operation, const ComputeRequest& request);

/// Whether to parse it takes no longer than the thread of a connection should.
bool is_quickly_parsed(const Operation& operation, const ComputeRequest& request);

/// Cost of parsing.
api::Cost cost_of_parsing(const Operation& operation, const ComputeRequest& request);

/// Cost of computing the answer where there is nothing but a copy of the request, which is parsed again there.
api::Cost cost_of_answering(const Operation& operation, const ComputeRequest& request, const ParsedRequest& parsed);

}  // namespace ccdt::server
