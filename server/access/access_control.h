// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <cstddef>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "core/base/result.h"
#include "server/access/key_ring.h"
#include "server/access/rate_limiter.h"
#include "server/access/shared_rate.h"
#include "server/http/http.h"

namespace ccdt::server {

/// Checks the credentials of requests, and limits the rate of each client.
///
/// The rate is counted by API key. Requests without a valid key are counted by address, so that a client cannot guess
/// keys quickly. Clients of a Unix socket have no address; without a key, their rate is not limited. CORS preflights
/// need no key, because browsers send none, and are counted by address. Requests with a signed URL are also counted by
/// address, because all visitors of a page use URLs signed with the same key. Thread-safe.
class AccessControl {
public:
    /// Credential that a request needs.
    enum class Credential {
        None,      ///< no credential; the rate is not limited
        Key,       ///< an API key, if any are configured
        Signature  ///< a signed URL, if signing keys are configured; otherwise the same as Key
    };

    /// Source of the signing keys: a file or a single key. If both are empty, there are no signing keys.
    struct SigningKeys {
        std::string file;
        std::string key;

        bool empty() const { return file.empty() && key.empty(); }
    };

    /// Minimum length of a signing key, in characters. Signing keys must be longer than API keys, because the owner of
    /// a signed URL can test guessed keys offline.
    static constexpr std::size_t kMinSigningKeyLength = 32;

    struct Verdict {
        std::string key;             ///< name of the request's API key; empty: none
        std::string client;          ///< key or address for which the rate is counted
        HttpResult<void> admission;  ///< success, or the reason for the refusal
        std::string signer;          ///< name of the key that signed the URL; empty: none
    };

    /// @param key_file  file of the API keys; empty: no key is needed
    /// @param rate      limit for each key or address
    /// @param shared    Redis in which servers share the counts; must outlive this object; null: counts are local
    AccessControl(std::string key_file, const RateLimiter::Rate& rate, RedisClient* shared = nullptr,
                  SigningKeys signing = {})
        : key_file_(std::move(key_file)), signing_(std::move(signing)), limiter_(rate) {
        if (shared != nullptr) shared_.emplace(*shared, rate);
    }

    /// Reads the configured keys. An error leaves the present keys in use.
    Result<void> read_keys();

    void set_rate(const RateLimiter::Rate& rate);

    /// Counts a request for its client's rate, and checks its credential.
    /// @param address  address of the client, used to count requests without a valid key; empty: none
    Verdict check(const Request& request, const std::string& address, Credential needed = Credential::Key);

private:
    /// API keys and signing keys; null: not configured.
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

/// Reads the signing keys from the file or, if no file is named, from `key`. Returns null if both are empty.
/// Errors: those of KeyRing; the message names the file or the environment variable.
Result<std::shared_ptr<const KeyRing>> read_signing_keys(const AccessControl::SigningKeys& signing);

}  // namespace ccdt::server
