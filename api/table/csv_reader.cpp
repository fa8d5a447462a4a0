// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/table/csv_reader.h"

#include <algorithm>
#include <array>

namespace ccdt::api {
namespace {

tl::unexpected<Error> wrong(std::string message) {
    return failure(ErrorCode::Malformed, std::move(message));
}

}  // namespace

char CsvReader::find_separator(std::string_view text) {
    const std::string_view line = text.substr(0, text.find('\n'));
    constexpr std::array kSeparators{',', ';', '\t'};
    return *std::ranges::max_element(kSeparators, {}, [line](char each) { return std::ranges::count(line, each); });
}

Result<bool> CsvReader::next() {
    fields_.clear();
    line_ = next_line_;
    if (rest_.empty()) return false;
    while (true) {
        if (auto read = read_field(); !read) return tl::unexpected(std::move(read.error()));
        if (rest_.empty()) return true;
        const char after = rest_.front();
        rest_.remove_prefix(1);
        if (after == separator_) continue;
        ++next_line_;
        return true;
    }
}

/// Reads a field up to the separator or the line break after it.
Result<void> CsvReader::read_field() {
    std::string& field = fields_.emplace_back();
    const std::array<char, 2> ends{separator_, '\n'};
    if (separator_ == '\t' || !rest_.starts_with('"')) {
        field = rest_.substr(0, rest_.find_first_of(std::string_view(ends.data(), ends.size())));
        rest_.remove_prefix(field.size());
        if (field.ends_with('\r')) field.pop_back();
        return {};
    }
    rest_.remove_prefix(1);
    while (true) {
        const auto quote = rest_.find('"');
        if (quote == std::string_view::npos) return wrong(position() + ": a quoted field has no end");
        field += rest_.substr(0, quote);
        rest_.remove_prefix(quote + 1);
        if (!rest_.starts_with('"')) break;
        field += '"';
        rest_.remove_prefix(1);
    }
    next_line_ += static_cast<std::size_t>(std::ranges::count(field, '\n'));
    if (rest_.starts_with("\r\n")) rest_.remove_prefix(1);
    if (rest_.empty() || rest_.front() == separator_ || rest_.front() == '\n') return {};
    return wrong(position() + ": there is text after a quoted field");
}

}  // namespace ccdt::api
