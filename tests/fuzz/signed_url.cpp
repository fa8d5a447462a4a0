// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <vector>

#include "server/access/signed_url.h"
#include "server/requests/digest.h"
#include "tests/fuzz/checks.h"

namespace ccdt::fuzz {
namespace {

using server::KeyRing;
using server::SignedUrl;

const std::string kKey(32, 'k');
constexpr std::string_view kName = "signature=", kExpires = "expires=";

bool is_signed(std::string_view resource, std::int64_t now) {
    static const auto keys = KeyRing::of("key", kKey);
    const auto url = SignedUrl::parse(resource);
    return url && url->check(*keys, std::chrono::sys_seconds(std::chrono::seconds(now))).has_value();
}

/// Splits a query into its parameters, independently of SignedUrl.
std::vector<std::string_view> parameters_of(std::string_view query) {
    std::vector<std::string_view> parameters;
    for (std::size_t begin = 0; begin <= query.size();) {
        const std::size_t end = std::min(query.find('&', begin), query.size());
        parameters.push_back(query.substr(begin, end - begin));
        begin = end + 1;
    }
    return parameters;
}

/// Checks that the resource consists of the signed text, a separator, and the name and value of the signature, and that
/// the options do not include the expiry.
void check_parts(const SignedUrl& url, std::string_view resource) {
    CCDT_CHECK(resource.starts_with(url.text));
    const auto rest = resource.substr(url.text.size());
    CCDT_CHECK(rest.empty() == !url.signature);
    if (url.signature) {
        CCDT_CHECK(rest.front() == (url.text.find('?') == std::string_view::npos ? '?' : '&'));
        CCDT_CHECK(rest.substr(1).starts_with(kName) && rest.substr(1 + kName.size()) == *url.signature);
        CCDT_CHECK(url.signature->find('&') == std::string_view::npos);
    }
    const auto mark = url.text.find('?');
    const auto query = mark == std::string_view::npos ? std::string_view() : url.text.substr(mark + 1);
    const auto is_time = [](std::string_view parameter) { return parameter.starts_with(kExpires); };
    const auto all = parameters_of(query);
    CCDT_CHECK(std::ranges::count_if(all, is_time) == (url.expires ? 1 : 0));
    CCDT_CHECK(std::ranges::none_of(parameters_of(url.options), is_time));
    CCDT_CHECK(url.options.size() + (url.expires ? kExpires.size() : 0) <= query.size());
}

/// Signs a text, and checks that it is accepted until it expires, and refused if one bit is changed.
void check_signing(std::string_view text, std::size_t position) {
    const char separator = text.find('?') == std::string_view::npos ? '?' : '&';
    std::string resource = std::string(text) + separator + std::string(kName) + server::sign(kKey, text);
    const auto url = SignedUrl::parse(resource);
    if (!url) return check_problem(url.error());
    CCDT_CHECK(url->text == text);
    CCDT_CHECK(is_signed(resource, 0) == (!url->expires || *url->expires > 0));
    if (url->expires && *url->expires < 1'000'000)
        CCDT_CHECK(!is_signed(resource, static_cast<std::int64_t>(*url->expires)));
    resource[position % resource.size()] ^= 1;
    CCDT_CHECK(!is_signed(resource, 0));
}

}  // namespace
}  // namespace ccdt::fuzz

/// Parses the input as the path and query of a URL.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace ccdt;
    const auto resource = fuzz::text_of(data, size);
    const auto url = server::SignedUrl::parse(resource);
    if (url)
        fuzz::check_parts(*url, resource);
    else
        fuzz::check_problem(url.error());
    CCDT_CHECK(!fuzz::is_signed(resource, 0));  // a fuzzer cannot guess a signature
    fuzz::check_signing(resource, size == 0 ? 0 : data[0]);
    return 0;
}
