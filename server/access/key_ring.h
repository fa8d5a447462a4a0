// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"

namespace ccdt::server {

/// The keys that clients may use.
class KeyRing {
public:
    static constexpr std::size_t kMinKeyLength = 16;

    /// Parses lines of `name:key` or `name key`. Empty lines and lines that begin with # are ignored. A name may have
    /// several keys, so that a key can be replaced while the old one is still valid.
    /// Errors (Malformed): a line of any other form; a key of fewer than `shortest` or more than 256 characters; a key
    /// that is listed under two names; a text without any key. The message names the line, never the key.
    static Result<KeyRing> parse(std::string_view text, std::size_t shortest = kMinKeyLength);

    /// Errors: those of parse(); Unusable if the file cannot be read.
    static Result<KeyRing> read(const std::string& file, std::size_t shortest = kMinKeyLength);

    /// Makes a ring of one key. Errors: those of parse(), without a line number.
    static Result<KeyRing> of(std::string name, std::string key, std::size_t shortest = kMinKeyLength);

    /// Finds the name of a key. Returns none if the key is unknown. The time taken depends neither on the keys nor on
    /// how much of `key` is correct.
    std::optional<std::string> find(std::string_view key) const;

    /// Finds the name of the key that signed `text`: with this key, sign() returns `signature`. Returns none if there
    /// is no such key. The time taken does not depend on how much of the signature is correct.
    std::optional<std::string> find_signer(std::string_view text, std::string_view signature) const;

private:
    struct Entry {
        std::string name;
        std::string key;
    };

    std::optional<std::string> find_if(const std::function<bool(std::string_view key)>& fits) const;

    std::vector<Entry> entries_;
};

/// Returns the key of an Authorization header of the form `Bearer KEY`; empty for any other header.
std::string_view bearer_key(std::string_view authorization);

}  // namespace ccdt::server
