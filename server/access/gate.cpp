#include "server/access/gate.h"

#include <string_view>
#include <utility>

namespace ccdt::server {
namespace {

/// Whether a browser asks before a request from another origin, which it does without a key.
bool is_preflight(const Request& request) {
    return request.method == "OPTIONS" && !request.header("Origin").empty() &&
           !request.header("Access-Control-Request-Method").empty();
}

tl::unexpected<Problem> no_key(bool none_shown) {
    auto refused = problem(401, none_shown ? "an API key is needed: Authorization: Bearer KEY" : "the key is unknown");
    refused.value().headers.push_back({"WWW-Authenticate", "Bearer"});
    return refused;
}

}  // namespace

Result<void> Gate::read_keys() {
    if (key_file_.empty()) return {};
    auto ring = KeyRing::read(key_file_);
    if (!ring) return tl::unexpected(std::move(ring.error()));
    const std::lock_guard lock(mutex_);
    keys_ = std::make_shared<const KeyRing>(std::move(*ring));
    return {};
}

Gate::Verdict Gate::check(const Request& request, const std::string& address, bool is_free) {
    if (is_free) return {{}, address, {}};
    const auto ring = keys();
    const auto key = bearer_key(request.header("Authorization"));
    const auto name = ring && !key.empty() ? ring->find(key) : std::nullopt;

    Verdict verdict{name.value_or(""), name ? "key " + *name : address, {}};
    const auto wait = verdict.client.empty() ? std::chrono::seconds(0) : take(verdict.client);
    if (wait.count() > 0) {
        verdict.admission = busy(429, "too many requests for this key or address (rate-limit)", wait);
    } else if (ring && !name && !is_preflight(request)) {
        verdict.admission = no_key(key.empty());
    }
    return verdict;
}

/// Counts a request where all servers do, or if that cannot be had here.
std::chrono::seconds Gate::take(const std::string& client) {
    const auto wait = shared_ ? shared_->take(client) : std::nullopt;
    return wait ? *wait : limiter_.take(client);
}

std::shared_ptr<const KeyRing> Gate::keys() const {
    const std::lock_guard lock(mutex_);
    return keys_;
}

}  // namespace ccdt::server
