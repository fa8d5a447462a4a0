// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "api/input/negotiation.h"
#include "api/text/text.h"
#include "server/access/key_ring.h"
#include "server/http/compression.h"
#include "server/http/cors.h"
#include "server/http/entity_tag.h"
#include "server/http/http.h"
#include "server/http/proxies.h"
#include "server/http/proxy_protocol.h"
#include "server/http/trace.h"
#include "tests/fuzz/checks.h"

namespace ccdt::fuzz {
namespace {

constexpr std::array<const api::FileFormat*, 3> kFormats = {&api::kJson, &api::kPng, &api::kSvg};

std::string in_capitals(std::string_view text) {
    std::string result(text);
    for (char& c : result) {
        if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
    }
    return result;
}

bool is_part_of(std::string_view part, std::string_view whole) {
    return part.empty() || (part.data() >= whole.data() && part.data() + part.size() <= whole.data() + whole.size());
}

bool is_blank(char c) {
    return c == ' ' || c == '\t';
}

/// Checks that media types and weights are case-insensitive.
void check_accept(std::string_view value) {
    const auto chosen = api::negotiate(value, kFormats);
    const auto again = api::negotiate(in_capitals(value), kFormats);
    CCDT_CHECK(chosen.has_value() == again.has_value());
    if (chosen) {
        CCDT_CHECK(*chosen < kFormats.size() && *chosen == *again);
    } else {
        check_error(chosen.error());
        CCDT_CHECK(chosen.error().code == ErrorCode::NotAcceptable);
    }
    // A single accepted type must be chosen.
    const auto preferred = api::negotiate("image/png", kFormats);
    CCDT_CHECK(preferred && *preferred == 1);
}

void check_accept_encoding(std::string_view value) {
    CCDT_CHECK(server::accepts_gzip(value) == server::accepts_gzip(in_capitals(value)));
    std::string refused(value);
    refused += ",gzip;q=0";
    CCDT_CHECK(!server::accepts_gzip(refused));
}

void check_traceparent(std::string_view value) {
    const auto trace = server::parse_traceparent(value);
    if (!trace) return;
    CCDT_CHECK(trace->id.size() == 32 && trace->parent.size() == 16);
    CCDT_CHECK(is_part_of(trace->id, value) && is_part_of(trace->parent, value));
    for (const auto text : {trace->id, trace->parent}) {
        CCDT_CHECK(text.find_first_not_of("0123456789abcdef") == std::string_view::npos);
        CCDT_CHECK(text.find_first_not_of('0') != std::string_view::npos);
    }
}

void check_authorization(std::string_view value) {
    const auto key = server::bearer_key(value);
    CCDT_CHECK(is_part_of(key, value));
    CCDT_CHECK(key.empty() || (!is_blank(key.front()) && !is_blank(key.back())));
}

void check_content_type(std::string_view value) {
    const auto type = server::media_type(value);
    CCDT_CHECK(type == server::media_type(in_capitals(value)));
    CCDT_CHECK(type.size() <= value.size() && type.find(';') == std::string::npos);
    CCDT_CHECK(type.empty() || (!is_blank(type.front()) && !is_blank(type.back())));
    const auto boundary = server::header_parameter(value, "boundary");
    CCDT_CHECK(boundary == server::header_parameter(value, "BOUNDARY"));
    CCDT_CHECK(boundary.size() <= value.size());
}

/// Checks that a preference is found after any other text.
void check_prefer(std::string_view value) {
    const auto asks = [](std::string_view text) {
        server::Request request;
        request.headers = {{"Prefer", std::string(text)}};
        return server::prefers(request, "respond-async");
    };
    CCDT_CHECK(asks(value) == asks(in_capitals(value)));
    CCDT_CHECK(asks(std::string(value) + ",respond-async"));
}

void check_if_none_match(std::string_view value) {
    constexpr std::string_view kName = "QsHqMYeUVm3IyJ0NtpjsZfdp";
    const auto tag = server::find_tag(value, kName);
    CCDT_CHECK(!tag || (is_part_of(*tag, value) && tag->find(kName) != std::string_view::npos));
    const std::string with_it = std::string(value) + ", \"" + std::string(kName) + '"';
    CCDT_CHECK(server::find_tag(with_it, kName));
}

/// Checks that only listed origins and, if allowed, origins of this machine may read answers.
void check_origin(std::string_view value) {
    CCDT_CHECK(!server::allows_origin({"loopback"}, value) || value.find("localhost") != std::string_view::npos ||
               value.find("127.") != std::string_view::npos || value.find("[::1]") != std::string_view::npos);
    for (const auto& header : server::cors_headers({"https://a.example"}, value)) {
        CCDT_CHECK(header.name != "Access-Control-Allow-Origin" || value == "https://a.example");
    }
}

/// Parses a value as the line before a chunk, and as the value of a trailer.
void check_framing(std::string_view value) {
    const auto is_forbidden = [](char c) { return (c >= 0 && c < ' ' && c != '\t') || c == 0x7f; };
    const auto size = server::parse_chunk_size(value);
    if (size) {
        CCDT_CHECK(std::ranges::none_of(value, is_forbidden));
        CCDT_CHECK(server::parse_chunk_size(in_capitals(value)) == *size);
        CCDT_CHECK(server::parse_chunk_size(std::string(value) + ";a=\"b;\"") == *size);
        CCDT_CHECK(!server::parse_chunk_size(std::string(value) + ';'));
    } else {
        check_problem(size.error());
    }
    const auto checked = server::check_trailer("X-Digest: " + std::string(value));
    CCDT_CHECK(!checked.has_value() == std::ranges::any_of(api::trim(value), is_forbidden));
    CCDT_CHECK(!server::check_trailer("Content-length:" + std::string(value)));
}

/// Returns the name of the client of a request with given headers from a trusted proxy.
std::string client_behind_proxy(const std::vector<server::Header>& headers) {
    const server::TrustedProxies proxies{{*server::IpNetwork::parse("10.0.0.1")}};
    server::Request request;
    request.headers = headers;
    return server::client_of(request, server::describe_peer(*server::IpAddress::parse("10.0.0.1")), proxies).name;
}

/// Checks that a client cannot choose its address by text before the address that the proxy appends. The text may only
/// cause that the proxy counts as the client.
void check_addresses(std::string_view value) {
    const std::string sent(value);
    const std::string added = "203.0.113.1";
    CCDT_CHECK(client_behind_proxy({{"X-Forwarded-For", sent + ", " + added}}) == added);
    CCDT_CHECK(client_behind_proxy({{"X-Forwarded-For", sent}, {"X-Forwarded-For", added}}) == added);
    CCDT_CHECK(client_behind_proxy({{"Forwarded", sent}, {"Forwarded", "for=" + added}}) == added);
    for (const std::string element : {"for=203.0.113.1", "for=\"203.0.113.1:80\";proto=https"}) {
        const auto client = client_behind_proxy({{"Forwarded", sent + ", " + element}});
        CCDT_CHECK(client == added || client == "10.0.0.1");
    }
    const auto header = server::parse_proxy_header(value);
    if (header) {
        CCDT_CHECK(header->size <= value.size());
        CCDT_CHECK((header->state == server::ProxyHeader::State::Whole) == (header->size > 0));
    } else {
        check_problem(header.error());
    }
}

}  // namespace
}  // namespace ccdt::fuzz

/// Parses the input as the value of each header that the server interprets.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace ccdt::fuzz;
    const auto value = text_of(data, size);
    check_accept(value);
    check_accept_encoding(value);
    check_traceparent(value);
    check_authorization(value);
    check_content_type(value);
    check_prefer(value);
    check_if_none_match(value);
    check_origin(value);
    check_framing(value);
    check_addresses(value);
    return 0;
}
