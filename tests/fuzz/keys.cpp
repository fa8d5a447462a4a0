// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>

#include "server/access/key_ring.h"
#include "tests/fuzz/checks.h"

namespace ccdt::fuzz {
namespace {

constexpr std::string_view kBlank = " \t\r";

std::string_view trim(std::string_view text) {
    const auto first = text.find_first_not_of(kBlank);
    return first == std::string_view::npos ? std::string_view()
                                           : text.substr(first, text.find_last_not_of(kBlank) - first + 1);
}

struct Entry {
    std::string_view name;
    std::string_view key;
};

/// Finds the entries of a key file, independently of KeyRing.
std::vector<Entry> entries_of(std::string_view text) {
    std::vector<Entry> entries;
    while (!text.empty()) {
        const auto line = trim(take_line(text));
        if (line.empty() || line.front() == '#') continue;
        const auto end = std::min(line.find_first_of(": \t"), line.size());
        entries.push_back({line.substr(0, end), trim(line.substr(std::min(end + 1, line.size())))});
    }
    return entries;
}

void check_ring(const server::KeyRing& ring, const std::vector<Entry>& entries) {
    CCDT_CHECK(!entries.empty());
    for (const auto& [name, key] : entries) {
        CCDT_CHECK(ring.find(key) == std::string(name));
        std::string wrong(key);
        wrong.back() = wrong.back() == '\x01' ? '\x02' : '\x01';
        CCDT_CHECK(!ring.find(wrong));
        CCDT_CHECK(!ring.find(key.substr(1)) || std::ranges::count(entries, key.substr(1), &Entry::key) > 0);
        std::string header = "bEARER  ";
        header.append(key).append(" ");
        CCDT_CHECK(server::bearer_key(header) == key);
    }
    CCDT_CHECK(!ring.find(""));
}

/// Checks that an error message, which is logged, names a line but contains no key.
void check_secrecy(const Error& error, const std::vector<Entry>& entries) {
    constexpr std::size_t kMinKeyLength = 16;
    CCDT_CHECK(error.message.starts_with("line ") || entries.empty());
    for (const Entry& entry : entries) {
        const bool may_be_words = entry.key.size() < kMinKeyLength || entry.key.find(' ') != std::string_view::npos;
        CCDT_CHECK(may_be_words || error.message.find(entry.key) == std::string::npos);
    }
}

}  // namespace
}  // namespace ccdt::fuzz

/// Parses the input as a key file.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace ccdt;
    const auto text = fuzz::text_of(data, size);
    const auto entries = fuzz::entries_of(text);
    const auto ring = server::KeyRing::parse(text);
    if (ring) {
        fuzz::check_ring(*ring, entries);
    } else {
        fuzz::check_error(ring.error());
        fuzz::check_secrecy(ring.error(), entries);
    }
    return 0;
}
