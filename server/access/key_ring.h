// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/result.h"

namespace ccdt::server {

/// A set of named keys: API keys, or keys that sign URLs.
class KeyRing {
public:
    static constexpr std::size_t kMinKeyLength = 16;

    /// Parses lines of `name:key` or `name key`. Ignores empty lines and lines that begin with #. A name may have
    /// several keys, so that the old key stays valid while clients change to the new one.
    /// Errors (Malformed): a line of another form; a key shorter than `shortest` or longer than 256 characters; a key
    /// with two names; a text without keys. The message names the line, never the key.
    static Result<KeyRing> parse(std::string_view text, std::size_t shortest = kMinKeyLength);

    /// Parses a file. Errors: those of parse(); Unusable if the file cannot be read.
    static Result<KeyRing> read(const std::string& file, std::size_t shortest = kMinKeyLength);

    /// Makes a ring of one key. Errors: those of parse(), without a line number.
    static Result<KeyRing> of(std::string name, std::string key, std::size_t shortest = kMinKeyLength);

    /// Returns the name of a key; none if the key is unknown. Takes the same time for any `key`, so that the time does
    /// not reveal a correct prefix.
    std::optional<std::string> find(std::string_view key) const;

    /// Returns the name of the key with which sign() computes `signature` for `text`; none if there is no such key. The
    /// time does not reveal a correct prefix of the signature.
    std::optional<std::string> find_signer(std::string_view text, std::string_view signature) const;

    std::vector<std::string> keys() const;

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
