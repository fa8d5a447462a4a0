// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/output/json_pieces.h"

#include <charconv>
#include <cmath>
#include <stdexcept>

#include "api/text/numbers.h"

namespace ccdt::api {

void append_number(std::string& out, double value) {
    if (!std::isfinite(value)) throw std::domain_error("a number of the answer is not finite");
    append_shortest(out, value);
}

void append_number(std::string& out, std::uint64_t value) {
    char digits[20];
    out.append(digits, std::to_chars(digits, digits + sizeof digits, value).ptr);
}

void append_index(std::string& out, std::uint32_t index) {
    append_number(out, std::uint64_t{index});
}

void append_numbers(std::string& out, std::span<const double> numbers) {
    append_array(out, numbers, [](std::string& to, double number) { append_number(to, number); });
}

void append_indices(std::string& out, std::span<const std::uint32_t> indices) {
    append_array(out, indices, append_index);
}

void write_ranks(Body& body, std::span<const std::uint32_t> ranks, const std::stop_token& stop) {
    if (ranks.empty()) return;
    body.text() += ",\"rank\":";
    write_list(body, ranks, append_index, stop);
}

void append_trace(std::string& out, std::span<const double> trace) {
    std::uint64_t iteration = 0;
    append_array(out, trace, [&](std::string& to, double variation) {
        to += "{\"iteration\":";
        append_number(to, iteration++);
        append_member(to, "variation", variation);
        to += '}';
    });
}

void append_low_frequency_power(std::string& out, std::optional<double> power) {
    if (power) {
        append_member(out, "low_frequency_power", *power);
    } else {
        out += ",\"low_frequency_power\":null";
    }
}

void append_elapsed(std::string& out, double milliseconds) {
    constexpr double kSteps = 1000;
    append_member(out, "elapsed_ms", std::round(milliseconds * kSteps) / kSteps);
}

}  // namespace ccdt::api
