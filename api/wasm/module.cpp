// SPDX-License-Identifier: GPL-3.0-or-later
// The functions of the module ccdt.wasm. README.md describes them, and loader.mjs calls them.
#include <algorithm>
#include <array>
#include <cstdint>
#include <string>
#include <string_view>
#include <typeinfo>
#include <utility>
#include <vector>

#include "api/image/bmp_reader.h"
#include "api/image/image_header.h"
#include "api/image/picture_reader.h"
#include "api/operation/parsed_request.h"
#include "api/problem.h"
#include "api/surface/surface_reader.h"
#include "api/text/text.h"
#include "core/base/executor.h"

/// Receives the completed share of the work. Returns whether the computation shall stop.
extern "C" __attribute__((import_module("ccdt"), import_name("progress"))) bool ccdt_progress(double share);

namespace ccdt::api {
namespace {

/// Largest memory of the module, as in CMakeLists.txt, less what remains for code and fragments.
constexpr std::size_t kMaxMemory = std::size_t{1800} << 20;

enum class Operation : std::uint32_t { Halftone, Sample, Analyze };

/// The request and its answer. A module computes one at a time.
struct State {
    std::string body;
    std::string texts;  ///< names and values, each followed by a zero; the first value is the media type of the body
    ParsedPointer parsed;
    Answer answer;
    std::string problem;
};

State& state() {
    static State only;
    return only;
}

/// Decodes pictures that are not compressed. The caller decodes others and passes their pixels as BMP.
template <class AnyPicture>
Result<AnyPicture> decode_bmp(std::string_view bytes, const Reading& reading, const std::stop_token& /*stop*/) {
    const auto header = read_image_header(bytes, reading.max_pixels);
    if (!header) return tl::unexpected(header.error());
    if (header->format != ImageFormat::Bmp)
        return failure(ErrorCode::Unsupported,
                       "WebAssembly decodes BMP only; decode the picture in the browser, or ask a server");
    const auto source = open_bmp(bytes);
    if (!source) return tl::unexpected(source.error());
    return read_picture<AnyPicture>(*source, nullptr, reading, new_plane);
}

Result<SurfaceContents> decode_surface(std::string_view bytes, const SurfaceHeader& header,
                                       const std::stop_token& stop) {
    return read_surface(bytes, header, [&](std::string_view picture, std::size_t max_pixels) {
        return decode_bmp<ColourPicture>(picture, Reading(max_pixels), stop);
    });
}

/// @param texts  names and values of options, each followed by a zero
std::vector<TextOption> options_of(std::string_view texts) {
    const auto take = [&] {
        const auto text = texts.substr(0, texts.find('\0'));
        texts.remove_prefix(std::min(text.size() + 1, texts.size()));
        return std::string(text);
    };
    std::vector<TextOption> options;
    while (!texts.empty()) {
        std::string name = take();
        options.push_back({std::move(name), take()});
    }
    return options;
}

Result<ParsedPointer> parse(Operation operation, std::string_view body, const std::vector<TextOption>& options,
                            std::string_view media_type) {
    switch (operation) {
        case Operation::Halftone: {
            const bool is_json = trim(body, " \t\r\n").starts_with('{');
            return parse_halftone_request(body, is_json ? HalftoneBody::Json : HalftoneBody::Picture, options, {}, {});
        }
        case Operation::Sample:
            return parse_sample_request(body, options, {}, {}, media_type);
        case Operation::Analyze:
            break;
    }
    return parse_analyze_request(body, options, {}, {}, media_type);
}

/// Refuses formats whose writers absent_codecs.cpp replaces. A drawing of an analysis contains a PNG.
Result<void> check_format(Operation operation, std::string_view format) {
    constexpr std::array<std::string_view, 8> kAbsent{"png", "jpeg",    "webp", "tiff",
                                                      "pdf", "pmtiles", "mask", "mask16"};
    const bool has_picture = operation == Operation::Analyze && format == "svg";
    if (!has_picture && std::ranges::find(kAbsent, format) == kAbsent.end()) return {};
    return failure(ErrorCode::NotAcceptable,
                   "WebAssembly cannot write " + std::string(format) +
                       "; use json, csv, npy or svg and draw the dots, or ask a server",
                   "format");
}

Result<void> check_memory(const Cost& cost) {
    if (cost.memory <= kMaxMemory) return {};
    return failure(ErrorCode::LimitExceeded, "the answer needs about " + std::to_string(cost.memory >> 20) +
                                                 " MiB, but WebAssembly has at most " +
                                                 std::to_string(kMaxMemory >> 20) + " MiB");
}

Result<Answer> run(const ParsedRequest& request) {
    std::stop_source stop;
    const auto progress = [&](const Progress& now) {
        if (ccdt_progress(now.done())) stop.request_stop();
    };
    Timings timings;
    return request.run({decode_bmp<Picture>, decode_bmp<ColourPicture>, decode_surface},
                       {stop.get_token(), progress, &inline_executor()}, timings, nullptr);
}

/// Stores the error for the caller. Returns false.
bool fail(const Error& error) {
    state().problem = problem_json(http_status(error.code), {}, error, {});
    return false;
}

/// Returns the text with a number: see README.md.
const std::string& text(std::uint32_t number) {
    const Answer& answer = state().answer;
    const std::array<const std::string*, 5> texts{&answer.body, &answer.media_type, &answer.warnings, &answer.repaired,
                                                  &state().problem};
    return *texts.at(number);
}

}  // namespace
}  // namespace ccdt::api

namespace api = ccdt::api;

// Functions that JavaScript calls.
#define CCDT_EXPORTED(name) extern "C" __attribute__((export_name(name)))

CCDT_EXPORTED("reserve_body") char* ccdt_reserve_body(std::size_t size) {
    api::state().parsed.reset();
    api::state().body.resize(size);
    return api::state().body.data();
}

CCDT_EXPORTED("reserve_texts") char* ccdt_reserve_texts(std::size_t size) {
    api::state().texts.resize(size);
    return api::state().texts.data();
}

CCDT_EXPORTED("parse") bool ccdt_parse(std::uint32_t operation) {
    auto& request = api::state();
    auto options = api::options_of(request.texts);
    const std::string type = std::move(options.front().value);
    options.erase(options.begin());
    auto parsed = api::parse(api::Operation{operation}, request.body, options, type);
    if (!parsed) return api::fail(parsed.error());
    const auto format = api::check_format(api::Operation{operation}, (*parsed)->format());
    if (!format) return api::fail(format.error());
    if (const auto checked = api::check_memory((*parsed)->cost()); !checked) return api::fail(checked.error());
    request.parsed = *std::move(parsed);
    return true;
}

CCDT_EXPORTED("seconds") double ccdt_seconds() {
    return api::state().parsed->cost().seconds;
}

CCDT_EXPORTED("run") bool ccdt_run() {
    auto answer = api::run(*api::state().parsed);
    api::state().parsed.reset();
    if (!answer) return api::fail(answer.error());
    api::state().answer = *std::move(answer);
    return true;
}

CCDT_EXPORTED("is_partial") bool ccdt_is_partial() {
    return api::state().answer.partial;
}

CCDT_EXPORTED("text") const char* ccdt_text(std::uint32_t number) {
    return api::text(number).data();
}

CCDT_EXPORTED("text_size") std::size_t ccdt_text_size(std::uint32_t number) {
    return api::text(number).size();
}

// Symbols that Debian's libraries for WebAssembly use but lack.
extern "C" {
[[noreturn]] void __cxa_throw(void* /*exception*/, std::type_info* /*type*/, void (* /*destructor*/)(void*)) {
    __builtin_trap();
}
void* __cxa_allocate_exception(std::size_t /*size*/) noexcept {
    __builtin_trap();
}
extern const std::uintptr_t __stack_chk_guard;
const std::uintptr_t __stack_chk_guard = 0x5ca1ab1e;
[[noreturn]] void __stack_chk_fail() {
    __builtin_trap();
}
}
