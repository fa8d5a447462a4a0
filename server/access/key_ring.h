#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"

namespace ccdt::server {

/// The keys that clients may show.
class KeyRing {
public:
    /// Reads lines of `name:key` or `name key`; empty ones and those that begin with # say nothing. A name may have
    /// several keys, so that one can be replaced while both are good.
    /// Errors (Malformed): a line that is none of these, a key shorter than 16 or longer than 256 characters, two names
    /// for a key, no key at all. The message names the line, never the key.
    static Result<KeyRing> parse(std::string_view text);

    /// Errors: as above; (Unusable) the file cannot be read.
    static Result<KeyRing> read(const std::string& file);

    /// Finds whose key it is; none: nobody's. Takes the same time whatever keys there are and however much of one is
    /// right.
    std::optional<std::string> find(std::string_view key) const;

private:
    struct Entry {
        std::string name;
        std::string key;
    };

    std::vector<Entry> entries_;
};

/// The key of an Authorization header, `Bearer KEY`; empty if it is none.
std::string_view bearer_key(std::string_view authorization);

}  // namespace ccdt::server
