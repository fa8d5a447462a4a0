// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/http/compression.h"

#include <zlib.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <new>

#include "api/text/text.h"
#include "server/http/http.h"

namespace ccdt::server {
namespace {

constexpr std::size_t kSmallest = 1'024;
constexpr std::size_t kPiece = 262'144;
constexpr int kLevel = 1;
constexpr int kGzip = 16;  ///< added to the window bits to get a gzip header instead of a zlib header
constexpr int kMemoryLevel = 8;

std::string_view take_item(std::string_view& list, std::string_view separator) {
    return api::trim(api::take_until(list, separator));
}

/// Returns the weight (`q`) of a coding from its parameters; 0 if the weight is malformed.
double weight_of(std::string_view parameters) {
    while (!parameters.empty()) {
        auto value = take_item(parameters, ";");
        if (!equals_ignoring_case(take_item(value, "="), "q")) continue;
        return api::parse_number<double>(value).value_or(0);
    }
    return 1;
}

}  // namespace

struct Gzip::Stream {
    z_stream state{};
    std::array<char, 16'384> buffer{};
};

Gzip::Gzip() : stream_(std::make_unique<Stream>()) {
    if (deflateInit2(&stream_->state, kLevel, Z_DEFLATED, MAX_WBITS + kGzip, kMemoryLevel, Z_DEFAULT_STRATEGY) != Z_OK)
        throw std::bad_alloc();
}

Gzip::~Gzip() {
    deflateEnd(&stream_->state);
}

void Gzip::add(std::string_view piece, bool last, std::string& target) {
    auto& [state, buffer] = *stream_;
    // zlib takes a pointer to non-const, but does not write to the input.
    state.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(piece.data()));
    state.avail_in = static_cast<uInt>(piece.size());
    do {
        state.next_out = reinterpret_cast<Bytef*>(buffer.data());
        state.avail_out = static_cast<uInt>(buffer.size());
        deflate(&state, last ? Z_FINISH : Z_NO_FLUSH);
        target.append(buffer.data(), buffer.size() - state.avail_out);
    } while (state.avail_out == 0);
}

bool is_compressible(std::string_view media_type) {
    const auto type = ::ccdt::server::media_type(media_type);
    const bool is_text = type.starts_with("text/") || type == "application/json" || type.ends_with("+json") ||
                         type.ends_with("+xml") || type == "application/javascript" ||
                         type == "application/postscript" || type == "application/vnd.hp-hpgl" ||
                         type == "image/vnd.dxf";
    return is_text && type != "text/event-stream";
}

bool is_worth_compressing(std::string_view media_type, std::string_view body) {
    return is_compressible(media_type) && body.size() > kSmallest;
}

bool accepts_gzip(std::string_view accept_encoding) {
    std::optional<double> gzip_weight;
    double other_weight = 0;
    double identity_weight = 0;
    while (!accept_encoding.empty()) {
        auto parameters = take_item(accept_encoding, ",");
        const auto coding = take_item(parameters, ";");
        const double weight = weight_of(parameters);
        if (equals_ignoring_case(coding, "gzip") || equals_ignoring_case(coding, "x-gzip")) gzip_weight = weight;
        if (equals_ignoring_case(coding, "identity")) identity_weight = weight;
        if (coding == "*") other_weight = weight;
    }
    const double weight = gzip_weight.value_or(other_weight);
    return weight > 0 && weight >= identity_weight;
}

std::optional<std::string> gzip(std::string_view text, const std::stop_token& stop) {
    std::string compressed;
    Gzip compressor;
    bool last = false;
    while (!last) {
        if (stop.stop_requested()) return std::nullopt;
        const auto piece = text.substr(0, kPiece);
        text.remove_prefix(piece.size());
        last = text.empty();
        compressor.add(piece, last, compressed);
    }
    return compressed;
}

}  // namespace ccdt::server
