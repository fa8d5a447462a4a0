// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <optional>
#include <span>
#include <string>

#include "api/input/file_formats.h"
#include "api/output/body.h"
#include "api/sample/choice/choice_request.h"
#include "core/points/choice/choice.h"

namespace ccdt::api {

/// Format of chosen candidates: a row of the table in choice_formats.cpp.
struct ChoiceFormat {
    FileFormat file;
    double bytes_per_site;  ///< memory of a chosen candidate in the answer; 0 for records
    bool has_records;       ///< whether the answer consists of records of the file with the candidates
    /// Writes the chosen candidates.
    /// @param partial  whether the search was stopped early
    void (*write)(const ChoiceRequest& request, const ChosenCandidates& chosen, bool partial, Body& body);
};

/// Returns all formats.
std::span<const ChoiceFormat* const> choice_formats();

/// Returns the formats for candidates from a kind of files, in the server's order of preference. The first one is that
/// of the file, if the file has records.
/// @param kind  none: the candidates are members of JSON
std::span<const ChoiceFormat* const> choice_formats(std::optional<PointFileKind> kind);

}  // namespace ccdt::api
