// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/http/http_client.h"

#include <curl/curl.h>
#include <sys/socket.h>

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <memory>
#include <new>
#include <optional>

#include "server/http/authorities.h"
#include "server/http/http.h"
#include "server/http/sockets.h"

namespace ccdt::server {
namespace {

constexpr std::size_t kMaxUrl = 1024;

template <class T, void (*release)(T*)>
struct Release {
    void operator()(T* handle) const { release(handle); }
};
using Url = std::unique_ptr<CURLU, Release<CURLU, curl_url_cleanup>>;
using Transfer = std::unique_ptr<CURL, Release<CURL, curl_easy_cleanup>>;
using HeaderList = std::unique_ptr<curl_slist, Release<curl_slist, curl_slist_free_all>>;

/// Returns a part of a URL; none if the URL does not have it.
std::optional<std::string> part_of(CURLU* url, CURLUPart part) {
    char* text = nullptr;
    if (curl_url_get(url, part, &text, CURLU_DEFAULT_PORT) != CURLUE_OK) return std::nullopt;
    const std::unique_ptr<char, Release<void, curl_free>> owner(text);
    return std::string(text);
}

/// Data of the callbacks of a transfer.
struct Context {
    const TargetHosts& hosts;
    const std::stop_token& stop;
    std::string refused;  ///< the last address that is not permitted
};

curl_socket_t open_socket(void* data, curlsocktype /*purpose*/, curl_sockaddr* target) {
    auto& context = *static_cast<Context*>(data);
    sockaddr_storage address{};
    std::memcpy(&address, &target->addr, std::min<std::size_t>(target->addrlen, sizeof(address)));
    const Peer peer = describe_peer(address);
    if (peer.ip && context.hosts.permits(*peer.ip))
        return ::socket(target->family, target->socktype | SOCK_CLOEXEC, target->protocol);
    context.refused = peer.ip ? peer.ip->text() : peer.name;
    return CURL_SOCKET_BAD;
}

/// @returns  1 to abort the transfer, otherwise 0
int check_stop(void* data, curl_off_t, curl_off_t, curl_off_t, curl_off_t) {
    return static_cast<Context*>(data)->stop.stop_requested() ? 1 : 0;
}

std::size_t ignore_body(const char* /*bytes*/, std::size_t size, std::size_t count, void* /*data*/) {
    return size * count;
}

HeaderList list_of(const std::vector<Header>& headers) {
    HeaderList list;
    for (const auto& [name, value] : headers) {
        const std::string line = std::string(name).append(": ").append(value);
        curl_slist* const longer = curl_slist_append(list.get(), line.c_str());
        if (longer == nullptr) throw std::bad_alloc();
        (void)list.release();  // part of the longer list
        list.reset(longer);
    }
    return list;
}

}  // namespace

Result<Origin> check_target(const std::string& url, const TargetHosts& hosts) {
    const auto is_visible = [](char c) { return c > ' ' && c < 0x7f; };
    const Url parsed(curl_url());
    if (parsed == nullptr) throw std::bad_alloc();
    if (url.size() > kMaxUrl || !std::ranges::all_of(url, is_visible) ||
        curl_url_set(parsed.get(), CURLUPART_URL, url.c_str(), CURLU_DISALLOW_USER) != CURLUE_OK)
        return failure(ErrorCode::Malformed,
                       "the URL must be absolute, without credentials, of at most 1024 characters");
    const auto scheme = part_of(parsed.get(), CURLUPART_SCHEME);
    if (scheme != "http" && scheme != "https") return failure(ErrorCode::Malformed, "the URL must be of http or https");
    if (part_of(parsed.get(), CURLUPART_FRAGMENT))
        return failure(ErrorCode::Malformed, "the URL must have no fragment");
    const std::string name = part_of(parsed.get(), CURLUPART_HOST).value_or("");
    const auto host = parse_host(name);
    Origin origin{*scheme, host.value_or(""), part_of(parsed.get(), CURLUPART_PORT).value_or("")};
    if (!host || !hosts.permits(origin))
        return failure(ErrorCode::Malformed, "the host " + name + " is not one of those that this server permits");
    return origin;
}

Result<int> post(const std::string& url, const std::vector<Header>& headers, const std::string& body,
                 const TargetHosts& hosts, std::chrono::milliseconds timeout, const std::stop_token& stop) {
    const Transfer transfer(curl_easy_init());
    if (transfer == nullptr) throw std::bad_alloc();
    const HeaderList list = list_of(headers);
    Context context{hosts, stop, {}};
    const auto set = [&](CURLoption option, auto value) {
        if (curl_easy_setopt(transfer.get(), option, value) == CURLE_OUT_OF_MEMORY) throw std::bad_alloc();
    };
    set(CURLOPT_URL, url.c_str());
    set(CURLOPT_PROTOCOLS_STR, "http,https");
    set(CURLOPT_PROXY, "");
    set(CURLOPT_HTTP_VERSION, static_cast<long>(CURL_HTTP_VERSION_1_1));
    set(CURLOPT_HTTPHEADER, list.get());
    set(CURLOPT_POSTFIELDSIZE_LARGE, static_cast<curl_off_t>(body.size()));
    set(CURLOPT_POSTFIELDS, body.data());
    set(CURLOPT_TIMEOUT_MS, static_cast<long>(timeout.count()));
    set(CURLOPT_NOSIGNAL, 1L);
    set(CURLOPT_QUICK_EXIT, 1L);  // does not wait for the look-up of a name after the time limit
    set(CURLOPT_OPENSOCKETFUNCTION, open_socket);
    set(CURLOPT_OPENSOCKETDATA, &context);
    set(CURLOPT_NOPROGRESS, 0L);
    set(CURLOPT_XFERINFOFUNCTION, check_stop);
    set(CURLOPT_XFERINFODATA, &context);
    set(CURLOPT_WRITEFUNCTION, ignore_body);
    set(CURLOPT_CAINFO, authorities_file().c_str());
    const CURLcode code = curl_easy_perform(transfer.get());
    if (code == CURLE_COULDNT_CONNECT && !context.refused.empty())
        return failure(ErrorCode::Unavailable, "its address " + context.refused + " is not public and not permitted");
    if (code != CURLE_OK) return failure(ErrorCode::Unavailable, curl_easy_strerror(code));
    long status = 0;
    curl_easy_getinfo(transfer.get(), CURLINFO_RESPONSE_CODE, &status);
    return static_cast<int>(status);
}

}  // namespace ccdt::server
