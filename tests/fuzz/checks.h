// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "api/run/options.h"
#include "core/result.h"
#include "server/http/http.h"

/// Ends the program, which a fuzzer takes for a crash, unless the condition holds. Unlike assert() it always looks.
#define CCDT_CHECK(condition) \
    (static_cast<bool>(condition) ? void() : ccdt::fuzz::give_up(#condition, __FILE__, __LINE__))

/// What libFuzzer, or replay.cpp, calls with each input. Every target defines it.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace ccdt::fuzz {

[[noreturn]] void give_up(const char* condition, const char* file, int line);

inline std::string_view text_of(const std::uint8_t* data, std::size_t size) {
    return {reinterpret_cast<const char*>(data), size};
}

/// The first line, without its end; `text` keeps what follows it.
std::string_view take_line(std::string_view& text);

/// An error says what is wrong, is not our own fault, and becomes an answer that is JSON.
void check_error(const Error& error);

/// The same, for what came as a JSON body: the field is a pointer to something in it, or to a member that is missing.
void check_error(const Error& error, std::string_view body);

/// The same, for what came as options: the field is one of their names, or that of an option that is missing.
void check_error(const Error& error, std::span<const api::TextOption> options);

/// A problem says what is wrong, with a status that HTTP has for it.
void check_problem(const server::Problem& problem);

/// Text that is JSON and, as all that goes out, has no bytes that are not UTF-8.
void check_json(std::string_view text);

/// Numbers off the front of an input; zeros after its end.
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
