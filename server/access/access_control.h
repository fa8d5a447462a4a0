// SPDX-License-Identifier: GPL-3.0-or-later
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

/// Checks the credentials and the rate of requests before they are handled.
///
/// Requests are counted by API key. Requests without a valid key are counted by address, so that a client cannot guess
/// keys quickly. Clients of a Unix socket have no address; without a key their rate is not limited. Browsers send
/// preflights without keys, so preflights need none and are counted by address. Requests with a signed URL are also
/// counted by address, because all visitors of a page have URLs signed by the same key. Thread-safe.
class AccessControl {
public:
    /// Credential that a request needs.
    enum class Credential {
        None,      ///< no credential; the request is not counted
        Key,       ///< an API key, if any are configured
        Signature  ///< a signed URL, if signing keys are configured; otherwise the same as Key
    };

    /// Source of the signing keys: a file or a single key. If both are empty, there are no signing keys.
    struct SigningKeys {
        std::string file;
        std::string key;

        bool empty() const { return file.empty() && key.empty(); }
    };

    /// Minimum length of a signing key, in characters. Signing keys must be longer than API keys, because whoever has a
    /// signed URL can try keys offline.
    static constexpr std::size_t kMinSigningKeyLength = 32;

    struct Verdict {
        std::string key;             ///< name of the API key that the request has; empty: none
        std::string client;          ///< key or address by which the request is counted
        HttpResult<void> admission;  ///< success, or the reason to refuse the request
        std::string signer;          ///< name of the key that signed the URL; empty: none
    };

    /// @param key_file  file of the API keys; empty: no key is needed
    /// @param rate      limit for each key or address
    /// @param shared    Redis in which several servers share their counts; must outlive this object; null: counts are
    ///                  local
    AccessControl(std::string key_file, const RateLimiter::Rate& rate, RedisClient* shared = nullptr,
                  SigningKeys signing = {})
        : key_file_(std::move(key_file)), signing_(std::move(signing)), limiter_(rate) {
        if (shared != nullptr) shared_.emplace(*shared, rate);
    }

    /// Reads the configured keys. After an error, the keys stay as they were.
    Result<void> read_keys();

    /// Counts a request, and checks that it has the credential that it needs.
    /// @param address  address of the client, by which a request without a valid key is counted; empty: none
    Verdict check(const Request& request, const std::string& address, Credential needed = Credential::Key);

private:
    /// The keys of both kinds; null: none are configured.
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
/// Errors: those of KeyRing; the message names the file or the variable.
Result<std::shared_ptr<const KeyRing>> read_signing_keys(const AccessControl::SigningKeys& signing);

}  // namespace ccdt::server
