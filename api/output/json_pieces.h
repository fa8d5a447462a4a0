// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>

#include "api/output/body.h"

namespace ccdt::api {

// Functions with which the writers of JSON answers build objects and lists.

inline constexpr std::size_t kJsonStopStride = 4'096;  ///< list elements between two checks of the stop token

/// Appends a number. Throws std::domain_error if the number is not finite, since JSON cannot express it and clients
/// expect a number.
void append_number(std::string& out, double value);
void append_number(std::string& out, std::uint64_t value);
void append_index(std::string& out, std::uint32_t index);

/// Writes an array. Calls `append_element(out, element)` for each element.
template <class Range, class AppendElement>
void append_array(std::string& out, const Range& range, AppendElement append_element) {
    out += '[';
    bool first = true;
    for (const auto& element : range) {
        if (!first) out += ',';
        first = false;
        append_element(out, element);
    }
    out += ']';
}

void append_numbers(std::string& out, std::span<const double> numbers);
void append_indices(std::string& out, std::span<const std::uint32_t> indices);

/// Writes a long list of `size` elements. Calls `append_element(out, i)` for each element. Ends early on a stop, or if
/// the sink of the body fails.
template <class AppendElement>
void write_list(Body& body, std::size_t size, AppendElement append_element, const std::stop_token& stop) {
    std::string& out = body.text();
    out += '[';
    for (std::size_t i = 0; i < size; ++i) {
        if (i % kJsonStopStride == 0 && (!body.flush() || stop.stop_requested())) break;
        if (i > 0) out += ',';
        append_element(out, i);
    }
    out += ']';
}

/// Writes a long list. Calls `append_element(out, element)` for each element.
template <class Element, class AppendElement>
void write_list(Body& body, std::span<const Element> list, AppendElement append_element, const std::stop_token& stop) {
    write_list(
        body, list.size(), [&](std::string& out, std::size_t i) { append_element(out, list[i]); }, stop);
}

/// Writes `,"rank":[...]`, or nothing if there are no ranks.
void write_ranks(Body& body, std::span<const std::uint32_t> ranks, const std::stop_token& stop);

/// Appends `,"name":value`.
template <class Number>
void append_member(std::string& out, std::string_view name, Number value) {
    out.append(",\"").append(name).append("\":");
    append_number(out, value);
}

/// Appends an array with the number of each iteration and the variation after it.
void append_trace(std::string& out, std::span<const double> trace);

/// Appends `,"low_frequency_power":value`; null without a value.
void append_low_frequency_power(std::string& out, std::optional<double> power);

/// Appends `,"elapsed_ms":value`, rounded to microseconds.
void append_elapsed(std::string& out, double milliseconds);

}  // namespace ccdt::api
