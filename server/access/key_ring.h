#pragma once

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/result.h"

namespace ccdt::server {

/// The keys that clients may show.
class KeyRing {
public:
    static constexpr std::size_t kShortestKey = 16;

    /// Reads lines of `name:key` or `name key`; empty ones and those that begin with # say nothing. A name may have
    /// several keys, so that one can be replaced while both are good.
    /// Errors (Malformed): a line that is none of these, a key of fewer than `shortest` or more than 256 characters,
    /// two names for a key, no key at all. The message names the line, never the key.
    static Result<KeyRing> parse(std::string_view text, std::size_t shortest = kShortestKey);

    /// Errors: as above; (Unusable) the file cannot be read.
    static Result<KeyRing> read(const std::string& file, std::size_t shortest = kShortestKey);

    /// Makes a ring of one key. Errors: as above, without a line.
    static Result<KeyRing> of(std::string name, std::string key, std::size_t shortest = kShortestKey);

    /// Finds whose key it is; none: nobody's. Takes the same time whatever keys there are and however much of one is
    /// right.
    std::optional<std::string> find(std::string_view key) const;

    /// Finds whose key makes that signature of a text, as `sign` does; none: nobody's. Takes the same time however much
    /// of the signature is right.
    std::optional<std::string> find_signer(std::string_view text, std::string_view signature) const;

private:
    struct Entry {
        std::string name;
        std::string key;
    };

    std::optional<std::string> find_if(const std::function<bool(std::string_view key)>& fits) const;

    std::vector<Entry> entries_;
};

/// The key of an Authorization header, `Bearer KEY`; empty if it is none.
std::string_view bearer_key(std::string_view authorization);

}  // namespace ccdt::server
