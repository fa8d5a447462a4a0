#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "core/result.h"
#include "server/access/key_ring.h"
#include "server/access/rate_limiter.h"
#include "server/access/shared_rate.h"
#include "server/http/http.h"

namespace ccdt::server {

/// Decides whether a request may pass: it needs what the server asks for, and must not come too often.
///
/// The rate is counted by key, or by address for those without a good one, so that keys cannot be guessed fast. Over a
/// Unix socket clients have no address, and are not limited without a key. Browsers send no keys with preflights, which
/// need none, and count by address. Whoever has a signed URL counts by address, too: all visitors of a page have URLs
/// of one key. May be used from any thread.
class Gate {
public:
    /// Credential that a request needs in order to pass.
    enum class Credential {
        None,      ///< nothing, whatever it shows, and it does not count
        Key,       ///< an API key, if there are any
        Signature  ///< the signature of a signing key, if there are any; else as Key
    };

    /// Source of the signing keys: a file, or one key itself. If both are empty, there are none.
    struct SigningKeys {
        std::string file;
        std::string key;

        bool empty() const { return file.empty() && key.empty(); }
    };

    /// Characters of the shortest signing key. Whoever sees a signed URL can try keys as fast as its computers allow.
    static constexpr std::size_t kShortestSigningKey = 32;

    struct Verdict {
        std::string key;             ///< the name of the API key that was shown; empty: none
        std::string client;          ///< who asks: the key or the address
        HttpResult<void> admission;  ///< why the request may not pass, if it may not
        std::string signer;          ///< the name of the key that signed the URL; empty: none
    };

    /// @param key_file  empty: no key is needed
    /// @param shared    Redis where servers count together, which must outlive it; null: each counts by itself
    Gate(std::string key_file, const RateLimiter::Rate& rate, RedisClient* shared = nullptr, SigningKeys signing = {})
        : key_file_(std::move(key_file)), signing_(std::move(signing)), limiter_(rate) {
        if (shared != nullptr) shared_.emplace(*shared, rate);
    }

    /// Reads the keys that are configured. After an error they are what they were.
    Result<void> read_keys();

    Verdict check(const Request& request, const std::string& address, Credential needed = Credential::Key);

private:
    /// Keys of both kinds; null: there are none of it.
    struct Keys {
        std::shared_ptr<const KeyRing> api;
        std::shared_ptr<const KeyRing> signing;
    };

    Keys keys() const;
    HttpResult<void> count(const std::string& client);
    std::chrono::seconds take(const std::string& client);
    Verdict check_key(const KeyRing* ring, const Request& request, const std::string& address);
    Verdict check_signature(const KeyRing& ring, const Request& request, const std::string& address);

    const std::string key_file_;
    const SigningKeys signing_;
    RateLimiter limiter_;
    std::optional<SharedRate> shared_;

    mutable std::mutex mutex_;  ///< guards the keys
    Keys keys_;
};

/// Reads signing keys: of the file or, if none is named, the key itself. None of either: null.
/// Errors: those of KeyRing, which name the file or the variable.
Result<std::shared_ptr<const KeyRing>> read_signing_keys(const Gate::SigningKeys& signing);

}  // namespace ccdt::server
