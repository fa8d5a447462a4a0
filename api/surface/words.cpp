// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/surface/words.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <limits>
#include <system_error>

namespace ccdt::api {
namespace {

enum class Kind : std::uint8_t { Letter, Blank, LineEnd, Comment, Backslash };

constexpr auto kKinds = [] {
    std::array<Kind, 256> kinds{};
    for (std::size_t c = 0; c <= ' '; ++c) kinds[c] = Kind::Blank;
    for (const char c : {'\n', '\r', '\f', '\0'}) kinds[static_cast<std::size_t>(c)] = Kind::LineEnd;
    kinds['#'] = Kind::Comment;
    kinds['\\'] = Kind::Backslash;
    return kinds;
}();

Kind kind_of(char c) {
    return kKinds[static_cast<unsigned char>(c)];
}

char lower(char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

}  // namespace

void Words::take_line_end() {
    at_ += *at_ == '\r' && at_ + 1 != end_ && at_[1] == '\n' ? 2 : 1;
    ++line_;
}

void Words::skip_line() {
    while (at_ != end_ && kind_of(*at_) != Kind::LineEnd) ++at_;
}

std::string_view Words::next_in_line() {
    while (at_ != end_) {
        switch (kind_of(*at_)) {
            case Kind::Letter: {
                const char* const begin = at_;
                while (at_ != end_ && kind_of(*at_) == Kind::Letter) ++at_;
                // A number that is not finite, such as 1.#QNAN.
                if (at_ != end_ && *at_ == '#' && at_[-1] == '.' && at_ - begin <= 3) {
                    do ++at_;
                    while (at_ != end_ && kind_of(*at_) == Kind::Letter);
                }
                return {begin, static_cast<std::size_t>(at_ - begin)};
            }
            case Kind::Blank:
                ++at_;
                break;
            case Kind::LineEnd:
                return {};
            case Kind::Comment:
                skip_line();
                break;
            case Kind::Backslash:
                do ++at_;
                while (at_ != end_ && kind_of(*at_) == Kind::Blank);
                if (at_ != end_ && kind_of(*at_) == Kind::LineEnd) take_line_end();
                break;
        }
    }
    return {};
}

std::string_view Words::next() {
    while (true) {
        const std::string_view word = next_in_line();
        if (!word.empty() || at_end()) return word;
        take_line_end();
    }
}

std::string quoted(std::string_view word) {
    constexpr std::size_t kLongest = 30;
    return '"' + std::string(word.substr(0, kLongest)) + '"';
}

std::optional<double> number_in(std::string_view word) {
    if (word.starts_with('+')) word.remove_prefix(1);
    if (word.empty() || word.front() == '+') return std::nullopt;
    double value = 0;
    const char* const end = word.data() + word.size();
    const auto [stopped, error] = std::from_chars(word.data(), end, value);
    if (stopped == end && error == std::errc()) return value;
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    const double sign = word.front() == '-' ? -1 : 1;
    if (stopped == end && error == std::errc::result_out_of_range) {
        const auto exponent = word.find_first_of("eE");
        const bool is_small =
            exponent == std::string_view::npos ? value == 0 : word.substr(exponent + 1).starts_with('-');
        return is_small ? sign * 0 : sign * kInfinity;
    }
    if (sign < 0) word.remove_prefix(1);
    if (is_keyword(word.substr(0, 5), "1.#in") && is_keyword(word.substr(5, 1), "f")) return sign * kInfinity;
    if (word.starts_with("1.#")) return std::numeric_limits<double>::quiet_NaN();
    return std::nullopt;
}

bool is_keyword(std::string_view word, std::string_view keyword) {
    return std::ranges::equal(word, keyword, {}, lower);
}

}  // namespace ccdt::api
