// SPDX-License-Identifier: GPL-3.0-or-later
#include <unistd.h>

#include <algorithm>
#include <cmath>

#include "api/problem.h"
#include "core/picture/tone.h"
#include "server/decoder/decoder_protocol.h"
#include "tests/fuzz/checks.h"
#include "tests/fuzz/shape_checks.h"

namespace ccdt::fuzz {
namespace {

constexpr std::size_t kMax = 4'096;  ///< limit of a picture's pixels, or of the bytes of a text or a mesh

bool is_share(float value) {
    return value >= 0 && value <= 1;
}

/// Checks that the planes of a picture have its size, and that the size is within the limit.
template <class AnyPicture>
void check_size(const AnyPicture& picture, const Plane& light) {
    CCDT_CHECK(picture.width >= 1 && picture.height >= 1);
    const std::size_t pixels = static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height);
    CCDT_CHECK(pixels <= kMax && light.size() == pixels);
    CCDT_CHECK(picture.alpha.empty() || picture.alpha.size() == pixels);
}

/// Checks that any value of a picture is converted to a valid coverage.
void check_product(const Picture& picture) {
    check_size(picture, picture.luminance);
    for (const Tone tone : {Tone::Linear, Tone::Perceptual, Tone::Density}) {
        for (const bool invert : {false, true})
            CCDT_CHECK(std::ranges::all_of(ink_coverage(picture, tone, invert), is_share));
    }
}

void check_product(const ColourPicture& picture) {
    for (const Plane* light : {&picture.red, &picture.green, &picture.blue}) {
        check_size(picture, *light);
        CCDT_CHECK(ink_coverage({picture.width, picture.height, *light, picture.alpha}, Tone::Linear, false).size() ==
                   light->size());
    }
}

/// Checks the size of a text. Its content is arbitrary.
void check_product(const std::string& text) {
    CCDT_CHECK(text.size() <= kMax);
}

/// Checks that the arrays of a mesh fit together. Coordinates are arbitrary.
void check_product(const api::SurfaceContents& contents) {
    check_soup(contents.soup);
}

template <class Reply>
void check_reply(const std::uint8_t* data, std::size_t size) {
    const auto file = Reply::make_file(kMax);
    const auto written = std::min(size, Reply::size(kMax));
    CCDT_CHECK(pwrite(file.get(), data, written, 0) == static_cast<ssize_t>(written));
    const Reply memory(file, kMax);
    CCDT_CHECK(memory);
    const auto reply = memory.read();
    if (!reply) return;
    if (*reply) {
        check_product(**reply);
    } else {
        CCDT_CHECK(!reply->error().message.empty());
        check_json(api::problem_json(422, "Unprocessable Content", reply->error(), "urn:request:1"));
    }
}

}  // namespace
}  // namespace ccdt::fuzz

/// Reads the input as a decoder's reply: the memory that a child shares with the server.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    ccdt::fuzz::check_reply<ccdt::server::ReplyMemory<ccdt::Picture>>(data, size);
    ccdt::fuzz::check_reply<ccdt::server::ReplyMemory<ccdt::ColourPicture>>(data, size);
    ccdt::fuzz::check_reply<ccdt::server::ReplyText>(data, size);
    ccdt::fuzz::check_reply<ccdt::server::ReplySurface>(data, size);
    return 0;
}
