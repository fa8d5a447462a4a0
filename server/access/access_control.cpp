// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/access/access_control.h"

#include <string_view>
#include <utility>

#include "server/access/signed_url.h"

namespace ccdt::server {
namespace {

/// Whether a request is a CORS preflight, which browsers send without a key.
bool is_preflight(const Request& request) {
    return request.method == "OPTIONS" && !request.header("Origin").empty() &&
           !request.header("Access-Control-Request-Method").empty();
}

tl::unexpected<Problem> no_key(bool none_shown) {
    auto refused =
        problem(401, none_shown ? "an API key is required: Authorization: Bearer KEY" : "the API key is unknown");
    refused.value().headers.push_back({"WWW-Authenticate", "Bearer"});
    return refused;
}

std::shared_ptr<const KeyRing> share(KeyRing ring) {
    return std::make_shared<const KeyRing>(std::move(ring));
}

Result<std::shared_ptr<const KeyRing>> read_api_keys(const std::string& file) {
    if (file.empty()) return nullptr;
    return KeyRing::read(file).map(share);
}

}  // namespace

Result<std::shared_ptr<const KeyRing>> read_signing_keys(const AccessControl::SigningKeys& signing) {
    constexpr std::string_view kVariable = "CCDT_SIGNING_KEY";
    if (signing.empty()) return nullptr;
    if (!signing.file.empty()) return KeyRing::read(signing.file, AccessControl::kMinSigningKeyLength).map(share);
    return KeyRing::of(std::string(kVariable), signing.key, AccessControl::kMinSigningKeyLength)
        .map(share)
        .map_error([&](Error error) {
            error.message.insert(0, std::string(kVariable) + ": ");
            return error;
        });
}

Result<void> AccessControl::read_keys() {
    auto api = read_api_keys(key_file_);
    if (!api) return tl::unexpected(std::move(api.error()));
    auto signing = read_signing_keys(signing_);
    if (!signing) return tl::unexpected(std::move(signing.error()));
    const std::lock_guard lock(mutex_);
    keys_ = {*std::move(api), *std::move(signing)};
    return {};
}

void AccessControl::set_rate(const RateLimiter::Rate& rate) {
    limiter_.set_rate(rate);
    if (shared_) shared_->set_rate(rate);
}

AccessControl::Verdict AccessControl::check(const Request& request, const std::string& address, Credential needed) {
    if (needed == Credential::None) return {{}, address, {}, {}};
    const Keys keys = this->keys();
    if (needed == Credential::Signature && keys.signing) return check_signature(*keys.signing, request, address);
    return check_key(keys.api.get(), request, address);
}

AccessControl::Verdict AccessControl::check_key(const KeyRing* ring, const Request& request,
                                                const std::string& address) {
    const auto key = bearer_key(request.header("Authorization"));
    const auto name = ring != nullptr && !key.empty() ? ring->find(key) : std::nullopt;
    Verdict verdict{name.value_or(""), name ? "key " + *name : address, {}, {}};
    verdict.admission = count(verdict.client);
    if (verdict.admission && ring != nullptr && !name && !is_preflight(request))
        verdict.admission = no_key(key.empty());
    return verdict;
}

AccessControl::Verdict AccessControl::check_signature(const KeyRing& ring, const Request& request,
                                                      const std::string& address) {
    Verdict verdict{{}, address, count(address), {}};
    if (!verdict.admission || is_preflight(request)) return verdict;
    const auto now = std::chrono::floor<std::chrono::seconds>(std::chrono::system_clock::now());
    const auto signer =
        SignedUrl::parse(request.resource).and_then([&](const SignedUrl& url) { return url.check(ring, now); });
    if (signer)
        verdict.signer = *signer;
    else
        verdict.admission = tl::unexpected(signer.error());
    return verdict;
}

/// Counts a request of a client, and refuses it if the rate limit is exceeded.
HttpResult<void> AccessControl::count(const std::string& client) {
    const auto wait = client.empty() ? std::chrono::seconds(0) : take(client);
    if (wait.count() == 0) return {};
    return busy(429, "too many requests for this key or address (rate-limit)", wait);
}

/// Counts a request in Redis, or locally if Redis is not configured or does not reply.
std::chrono::seconds AccessControl::take(const std::string& client) {
    const auto wait = shared_ ? shared_->take(client) : std::nullopt;
    return wait ? *wait : limiter_.take(client);
}

AccessControl::Keys AccessControl::keys() const {
    const std::lock_guard lock(mutex_);
    return keys_;
}

}  // namespace ccdt::server
