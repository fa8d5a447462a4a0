#include <unistd.h>

#include <algorithm>
#include <cmath>

#include "api/problem.h"
#include "core/halftone/tone.h"
#include "server/decoder/decoder_protocol.h"
#include "tests/fuzz/checks.h"

namespace ccdt::fuzz {
namespace {

constexpr std::size_t kMostPixels = 4'096;

bool is_share(float value) {
    return value >= 0 && value <= 1;
}

/// Every value can be read, and whatever it is becomes a tone.
void check_picture(const Picture& picture) {
    CCDT_CHECK(picture.width >= 1 && picture.height >= 1);
    const std::size_t pixels = static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height);
    CCDT_CHECK(pixels <= kMostPixels && picture.luminance.size() == pixels);
    CCDT_CHECK(picture.alpha.empty() || picture.alpha.size() == pixels);
    for (const Tone tone : {Tone::Linear, Tone::Perceptual}) {
        for (const bool invert : {false, true})
            CCDT_CHECK(std::ranges::all_of(ink_coverage(picture, tone, invert), is_share));
    }
}

}  // namespace
}  // namespace ccdt::fuzz

/// What a child that decodes a picture may leave in the memory that it shares with the server.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace ccdt;
    const auto file = server::make_reply_file(fuzz::kMostPixels);
    const auto written = std::min(size, server::ReplyMemory::size(fuzz::kMostPixels));
    CCDT_CHECK(pwrite(file.get(), data, written, 0) == static_cast<ssize_t>(written));
    const server::ReplyMemory memory(file, fuzz::kMostPixels);
    CCDT_CHECK(memory);
    const auto reply = memory.read();
    if (!reply) return 0;
    if (*reply) {
        fuzz::check_picture(**reply);
    } else {
        CCDT_CHECK(!reply->error().message.empty());
        fuzz::check_json(api::problem_json(422, "Unprocessable Content", reply->error(), "urn:request:1"));
    }
    return 0;
}
