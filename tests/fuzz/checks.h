// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "api/run/options.h"
#include "core/base/result.h"
#include "server/http/http.h"

/// Aborts the program if the condition is false; the fuzzer reports a crash. Unlike assert(), never disabled.
#define CCDT_CHECK(condition) \
    (static_cast<bool>(condition) ? void() : ccdt::fuzz::give_up(#condition, __FILE__, __LINE__))

/// The entry point of a target, which libFuzzer or replay.cpp calls with each input.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace ccdt::fuzz {

[[noreturn]] void give_up(const char* condition, const char* file, int line);

inline std::string_view text_of(const std::uint8_t* data, std::size_t size) {
    return {reinterpret_cast<const char*>(data), size};
}

/// Removes the first line from a text, and returns it without its line end.
std::string_view take_line(std::string_view& text);

/// Checks that an error has a message, is not internal, and is converted to a valid JSON document.
void check_error(const Error& error);

/// Checks an error about a JSON body: its field is a JSON Pointer to a value of the body, or to a missing member.
void check_error(const Error& error, std::string_view body);

/// Checks an error about options: its field is empty or the name of an option.
void check_error(const Error& error, std::span<const api::TextOption> options);

/// Checks that a problem has a message and a standard 4xx status, and is converted to a valid JSON document.
void check_problem(const server::Problem& problem);

/// Checks that a text is valid JSON in valid UTF-8.
void check_json(std::string_view text);

/// Takes numbers from the front of an input; zeros after its end.
class Bytes {
public:
    explicit Bytes(std::string_view bytes) : bytes_(bytes) {}

    bool empty() const { return bytes_.empty(); }

    template <class T>
    T take() {
        T value{};
        const std::size_t size = bytes_.copy(reinterpret_cast<char*>(&value), sizeof value);
        bytes_.remove_prefix(size);
        return value;
    }

private:
    std::string_view bytes_;
};

}  // namespace ccdt::fuzz
