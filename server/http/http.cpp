// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/http/http.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <optional>
#include <utility>

#include "api/text/text.h"

namespace ccdt::server {
namespace {

constexpr std::string_view kLineEnd = "\r\n";
constexpr std::string_view kAuthority = "://";      ///< separates scheme and authority
constexpr std::size_t kLongestRequestLine = 8'192;  ///< including its CRLF [bytes]

/// Fields that the server reads and that must not be repeated. Otherwise, a proxy and the server might use different
/// values. Content-Length and Transfer-Encoding are checked in read_framing().
constexpr std::array<std::string_view, 6> kSingleFields{
    "Access-Control-Request-Method", "Authorization", "Content-Type", "Host", "Origin", "X-Request-ID"};

char to_lower(char c) {
    return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
}

bool is_digit(char c) {
    return c >= '0' && c <= '9';
}

bool is_token_character(char c) {
    return is_digit(c) || (to_lower(c) >= 'a' && to_lower(c) <= 'z') ||
           std::string_view("!#$%&'*+-.^_`|~").find(c) != std::string_view::npos;
}

/// Whether RFC 3986 permits a character in `host:port`.
bool is_host_character(char c) {
    return is_digit(c) || (to_lower(c) >= 'a' && to_lower(c) <= 'z') ||
           std::string_view("-._~%!$&'()*+;=:[]").find(c) != std::string_view::npos;
}

bool is_token(std::string_view text) {
    return !text.empty() && std::ranges::all_of(text, is_token_character);
}

bool is_control(char c) {
    return (c >= 0 && c < ' ') || c == 0x7f;
}

int hex_value(char c) {
    if (is_digit(c)) return c - '0';
    const char small = to_lower(c);
    return small >= 'a' && small <= 'f' ? small - 'a' + 10 : -1;
}

/// Decodes percent-encoding. A percent sign that does not begin an escape stays as it is.
std::string decode_percent(std::string_view text, bool plus_is_space) {
    std::string decoded;
    decoded.reserve(text.size());
    for (std::size_t i = 0; i < text.size(); ++i) {
        const bool escape = text[i] == '%' && i + 2 < text.size();
        const int high = escape ? hex_value(text[i + 1]) : -1;
        const int low = escape ? hex_value(text[i + 2]) : -1;
        if (high >= 0 && low >= 0) {
            decoded += static_cast<char>(high * 16 + low);
            i += 2;
        } else {
            decoded += plus_is_space && text[i] == '+' ? ' ' : text[i];
        }
    }
    return decoded;
}

/// The parts of a request target.
struct Target {
    std::string_view authority;  ///< authority of an absolute-form target, which proxies may send; otherwise empty
    std::string_view resource;   ///< path and query
};

/// Splits a request target; none if it has neither origin-form nor absolute-form.
std::optional<Target> take_apart(std::string_view target) {
    if (target.starts_with('/')) return Target{{}, target};
    const auto colon = target.find(kAuthority);
    if (colon == std::string_view::npos) return std::nullopt;
    const auto scheme = target.substr(0, colon);
    if (!equals_ignoring_case(scheme, "http") && !equals_ignoring_case(scheme, "https")) return std::nullopt;
    target.remove_prefix(colon + kAuthority.size());
    const auto authority = target.substr(0, target.find_first_of("/?#"));
    if (authority.empty() || authority.front() == ':' || !std::ranges::all_of(authority, is_host_character))
        return std::nullopt;
    return Target{authority, target.substr(authority.size())};
}

HttpResult<void> parse_request_line(std::string_view line, Request& request) {
    const bool is_long = line.size() + kLineEnd.size() > kLongestRequestLine;
    const auto method = api::take_until(line, " ");
    const auto target = api::take_until(line, " ");
    if (!is_token(method) || target.empty()) return problem(400, "the request line is malformed");
    if (line != "HTTP/1.1" && line != "HTTP/1.0") return problem(400, "the protocol is not HTTP/1.1 or HTTP/1.0");
    if (is_long)
        return problem(414, "the request line is longer than " + std::to_string(kLongestRequestLine) + " bytes");
    if (std::ranges::any_of(target, is_control)) return problem(400, "the request target contains control characters");
    request.method = method;
    request.target = target;
    request.is_http_1_0 = line == "HTTP/1.0";
    request.keep_alive = !request.is_http_1_0;

    const bool whole_server = target == "*" && method == "OPTIONS";
    const auto parts = whole_server ? Target{{}, target} : take_apart(target);
    if (!parts) return problem(400, "the request target is neither a path nor a URL of http or https");
    request.authority = parts->authority;
    auto rest = parts->resource.substr(0, parts->resource.find('#'));
    request.resource = rest;
    const auto path = api::take_until(rest, "?");
    request.path = path.empty() ? "/" : decode_percent(path, false);
    request.query = rest;
    return {};
}

HttpResult<Header> parse_header(std::string_view line) {
    const auto colon = line.find(':');
    if (colon == std::string_view::npos || !is_token(line.substr(0, colon)))
        return problem(400, "a header line is malformed");
    const auto value = api::trim(line.substr(colon + 1));
    if (std::ranges::any_of(value, [](char c) { return is_control(c) && c != '\t'; }))
        return problem(400, "a header's value contains control characters");
    return Header{std::string(line.substr(0, colon)), std::string(value)};
}

/// Whether a field may be a trailer. RFC 9110, 6.5.1, forbids fields of framing, routing, authentication and format.
bool may_be_trailer(std::string_view name) {
    constexpr std::string_view kForbidden[] = {
        "Authorization", "Connection",        "Content-Encoding", "Content-Length",
        "Content-Range", "Content-Type",      "Expect",           "Host",
        "Keep-Alive",    "Max-Forwards",      "Prefer",           "TE",
        "Trailer",       "Transfer-Encoding", "Upgrade"};
    return std::ranges::none_of(kForbidden,
                                [name](std::string_view other) { return equals_ignoring_case(name, other); });
}

std::string_view skip_blanks(std::string_view text) {
    return text.substr(std::min(text.find_first_not_of(" \t"), text.size()));
}

/// Returns the text after the token at its beginning; none if it does not begin with a token.
std::optional<std::string_view> after_token(std::string_view text) {
    const auto* const end = std::ranges::find_if_not(text, is_token_character);
    if (end == text.begin()) return std::nullopt;
    return std::string_view(end, text.end());
}

/// Returns the text after the quoted string at its beginning; none if it does not begin with a complete quoted string.
std::optional<std::string_view> after_quoted(std::string_view text) {
    bool escaped = false;
    for (std::size_t i = 1; i < text.size(); ++i) {
        if (is_control(text[i]) && text[i] != '\t') return std::nullopt;
        if (text[i] == '"' && !escaped) return text.substr(i + 1);
        escaped = text[i] == '\\' && !escaped;
    }
    return std::nullopt;
}

/// Whether a text consists of zero or more chunk extensions: RFC 9112, section 7.1.1.
bool are_extensions(std::string_view text) {
    while (!text.empty()) {
        text = skip_blanks(text);
        if (!text.starts_with(';')) return false;
        auto rest = after_token(skip_blanks(text.substr(1)));
        if (!rest) return false;
        if (const auto value = skip_blanks(*rest); value.starts_with('=')) {
            const auto content = skip_blanks(value.substr(1));
            rest = content.starts_with('"') ? after_quoted(content) : after_token(content);
            if (!rest) return false;
        }
        text = *rest;
    }
    return true;
}

HttpResult<void> read_content_length(std::string_view value, Request& request) {
    if (request.content_length) return problem(400, "there is more than one Content-Length");
    request.content_length = api::parse_number<std::uint64_t>(value);
    if (!request.content_length) return problem(400, "Content-Length is not a number");
    return {};
}

HttpResult<void> read_transfer_encoding(std::string_view value, Request& request) {
    if (request.chunked || !equals_ignoring_case(value, "chunked"))
        return problem(400, "the only supported Transfer-Encoding is a single `chunked`");
    request.chunked = true;
    return {};
}

void read_connection(std::string_view value, Request& request) {
    while (!value.empty()) {
        const auto option = api::trim(api::take_until(value, ","));
        if (equals_ignoring_case(option, "close")) request.keep_alive = false;
        if (equals_ignoring_case(option, "keep-alive")) request.keep_alive = true;
    }
}

HttpResult<void> read_framing(Request& request) {
    for (const auto& [name, value] : request.headers) {
        HttpResult<void> read;
        if (equals_ignoring_case(name, "Content-Length")) read = read_content_length(value, request);
        if (equals_ignoring_case(name, "Transfer-Encoding")) read = read_transfer_encoding(value, request);
        if (!read) return read;
        if (equals_ignoring_case(name, "Connection")) read_connection(value, request);
        if (equals_ignoring_case(name, "Expect"))
            request.expects_continue = !request.is_http_1_0 && equals_ignoring_case(value, "100-continue");
    }
    if (request.chunked && (request.content_length || request.is_http_1_0))
        return problem(400, "Transfer-Encoding cannot be combined with Content-Length or HTTP/1.0");
    return {};
}

}  // namespace

bool equals_ignoring_case(std::string_view a, std::string_view b) {
    return std::ranges::equal(a, b, {}, to_lower, to_lower);
}

std::string to_lower_case(std::string_view text) {
    std::string small(text);
    std::ranges::transform(small, small.begin(), to_lower);
    return small;
}

std::string_view Request::header(std::string_view name) const {
    const auto found =
        std::ranges::find_if(headers, [&](const Header& header) { return equals_ignoring_case(header.name, name); });
    return found == headers.end() ? std::string_view() : found->value;
}

HttpResult<Request> parse_head(std::string_view head) {
    Request request;
    auto parsed = parse_request_line(api::take_until(head, kLineEnd), request);
    while (parsed && head != kLineEnd) {
        if (head.empty()) return problem(400, "the head of the request is incomplete");
        parsed = parse_header(api::take_until(head, kLineEnd)).map([&](Header header) {
            request.headers.push_back(std::move(header));
        });
    }
    if (request.authority.empty()) request.authority = request.header("Host");
    if (parsed) parsed = read_framing(request);
    if (!parsed) return tl::unexpected(parsed.error());
    return request;
}

HttpResult<std::uint64_t> parse_chunk_size(std::string_view line) {
    constexpr std::size_t kMaxDigits = 16;
    const auto digits = line.substr(0, std::min(line.find_first_of("; \t"), line.size()));
    const auto size = api::parse_number<std::uint64_t>(digits, 16);
    if (!size || digits.size() > kMaxDigits) return problem(400, "a chunk's size is malformed");
    if (!are_extensions(line.substr(digits.size()))) return problem(400, "a chunk's extensions are malformed");
    return *size;
}

HttpResult<void> check_trailer(std::string_view line) {
    const auto trailer = parse_header(line);
    if (!trailer) return problem(400, "a trailer is malformed");
    if (!may_be_trailer(trailer->name)) return problem(400, trailer->name + " must not be a trailer");
    return {};
}

HttpResult<void> check_request(const Request& request) {
    const auto has_name = [](std::string_view name) {
        return [name](const Header& header) { return equals_ignoring_case(header.name, name); };
    };
    for (const auto& name : kSingleFields) {
        if (std::ranges::count_if(request.headers, has_name(name)) > 1)
            return problem(400, "there must be only one " + std::string(name) + " header");
    }
    if (!request.is_http_1_0 && std::ranges::none_of(request.headers, has_name("Host")))
        return problem(400, "there must be a Host header");
    if (!std::ranges::all_of(request.header("Host"), is_host_character))
        return problem(400, "the Host header is malformed");
    const bool expects = std::ranges::any_of(request.headers, has_name("Expect"));
    if (expects && !request.is_http_1_0 && !request.expects_continue)
        return problem(417, "the only supported Expect is 100-continue");
    return {};
}

std::optional<std::string_view> take_unquoted(std::string_view& text, char separator) {
    bool quoted = false;
    std::size_t at = 0;
    for (; at < text.size() && (quoted || text[at] != separator); ++at) {
        if (text[at] == '"') quoted = !quoted;
        if (quoted && text[at] == '\\') ++at;
    }
    if (quoted || at > text.size()) return std::nullopt;
    const auto part = text.substr(0, at);
    text.remove_prefix(std::min(at + 1, text.size()));
    return part;
}

std::optional<std::string_view> find_preference(const Request& request, std::string_view preference) {
    for (const auto& [name, value] : request.headers) {
        std::string_view rest = equals_ignoring_case(name, "Prefer") ? value : std::string_view();
        while (!rest.empty()) {
            auto given = take_unquoted(rest, ',');
            if (!given) given = api::take_until(rest, ",");
            if (equals_ignoring_case(api::trim(given->substr(0, given->find_first_of("=;"))), preference)) return given;
        }
    }
    return std::nullopt;
}

std::vector<api::TextOption> parse_query(std::string_view query) {
    std::vector<api::TextOption> options;
    while (!query.empty()) {
        auto value = api::take_until(query, "&");
        if (value.empty()) continue;
        const auto name = api::take_until(value, "=");
        options.push_back({decode_percent(name, true), decode_percent(value, true)});
    }
    return options;
}

std::optional<std::string> take_parameter(std::string& query, std::string_view name) {
    std::optional<std::string> value;
    std::string others;
    for (std::string_view rest = query; !rest.empty();) {
        const auto parameter = api::take_until(rest, "&");
        auto content = parameter;
        if (decode_percent(api::take_until(content, "="), true) == name)
            value = decode_percent(content, true);
        else
            others.append(others.empty() ? "" : "&").append(parameter);
    }
    if (value) query = std::move(others);
    return value;
}

std::string encode_percent(std::string_view text) {
    std::string encoded;
    for (const char c : text) {
        const auto byte = static_cast<unsigned char>(c);
        if (is_digit(c) || (to_lower(c) >= 'a' && to_lower(c) <= 'z') || c == '.' || c == '-' || c == '_') {
            encoded += c;
        } else {
            encoded += {'%', "0123456789ABCDEF"[byte / 16], "0123456789ABCDEF"[byte % 16]};
        }
    }
    return encoded;
}

std::string media_type(std::string_view content_type) {
    return to_lower_case(api::trim(content_type.substr(0, content_type.find(';'))));
}

std::string header_parameter(std::string_view value, std::string_view name) {
    api::take_until(value, ";");
    std::optional<std::string> found;
    while (!value.empty()) {
        const auto key = api::trim(api::take_until(value, "="));
        value = value.substr(std::min(value.find_first_not_of(" \t"), value.size()));
        std::string content;
        if (value.starts_with('"')) {
            std::size_t i = 1;
            for (; i < value.size() && value[i] != '"'; ++i) {
                if (value[i] == '\\' && i + 1 < value.size()) ++i;
                content += value[i];
            }
            value.remove_prefix(std::min(i, value.size()));
            api::take_until(value, ";");
        } else {
            content = api::trim(api::take_until(value, ";"));
        }
        if (!equals_ignoring_case(key, name)) continue;
        if (found) return {};
        found = std::move(content);
    }
    return found.value_or("");
}

std::string_view status_phrase(int status) {
    constexpr auto kPhrases = std::to_array<std::pair<int, std::string_view>>({
        {200, "OK"},
        {202, "Accepted"},
        {204, "No Content"},
        {206, "Partial Content"},
        {304, "Not Modified"},
        {400, "Bad Request"},
        {401, "Unauthorized"},
        {403, "Forbidden"},
        {404, "Not Found"},
        {405, "Method Not Allowed"},
        {406, "Not Acceptable"},
        {408, "Request Timeout"},
        {409, "Conflict"},
        {410, "Gone"},
        {411, "Length Required"},
        {413, "Content Too Large"},
        {414, "URI Too Long"},
        {415, "Unsupported Media Type"},
        {416, "Range Not Satisfiable"},
        {417, "Expectation Failed"},
        {421, "Misdirected Request"},
        {422, "Unprocessable Content"},
        {429, "Too Many Requests"},
        {431, "Request Header Fields Too Large"},
        {499, "Client Closed Request"},
        {500, "Internal Server Error"},
        {503, "Service Unavailable"},
        {504, "Gateway Timeout"},
        {507, "Insufficient Storage"},
    });
    const auto* found = std::ranges::find(kPhrases, status, &std::pair<int, std::string_view>::first);
    return found == kPhrases.end() ? "Error" : found->second;
}

}  // namespace ccdt::server
