// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "api/run/options.h"
#include "core/base/result.h"
#include "server/http/multipart.h"
#include "server/requests/compute_request.h"

namespace ccdt::server {

/// Named options, to which the option `preset` of a query or form refers.
class Presets {
public:
    /// Parses a JSON object. Its members are the presets: objects whose members are options as in a query. Values other
    /// than texts are passed on as JSON.
    /// Errors (Malformed): another form; a name with other characters than letters, digits, dots and dashes; a preset
    /// without options; an option that neither /halftone nor /sample has.
    static Result<Presets> parse(std::string_view json);

    /// Replaces the option `preset` by its options, in the query. Options that the query or the form gives itself are
    /// not replaced.
    ///
    /// @param fields  see find_fields(); a field `preset` is removed
    /// @param only    whether a preset must be given, and no other option in the query
    /// Errors (Malformed): the preset is unknown or given twice; the query has other options, or there is no preset,
    /// although `only` is set. The field is the name of the option.
    Result<void> expand(ComputeRequest& request, std::vector<FormPart>& fields, bool only) const;

    std::vector<std::string> names() const;

private:
    std::map<std::string, std::vector<api::TextOption>> presets_;
};

}  // namespace ccdt::server
