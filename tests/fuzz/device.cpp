// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/halftone/device_picture.h"
#include "server/http/http.h"
#include "tests/fuzz/answer_checks.h"
#include "tests/fuzz/extreme_pictures.h"

namespace ccdt::fuzz {
namespace {

constexpr api::Limits kLimits = {.max_sites = 64, .max_pixels = 2'048};

/// The first bytes of a JPEG of 2 x 1 pixels. The picture itself is made by decode_of().
constexpr std::string_view kImage("\xff\xd8\xff\xc0\0\x0b\x08\0\1\0\2\1", 12);

/// Checks the rows of pixel values.
void check_rows(const api::DeviceRequest& request, std::string_view body) {
    const auto bits = static_cast<std::size_t>(request.device.bits());
    CCDT_CHECK(!body.empty() && body.size() <= kLimits.max_pixels);
    if (!request.width || !request.height) return;
    const auto width = static_cast<std::size_t>(*request.width), height = static_cast<std::size_t>(*request.height);
    const std::size_t row_size = (width * bits + 7) / 8;
    CCDT_CHECK(body.size() == row_size * height);
    if (request.pixels.lsb_first || request.pixels.inverted) return;
    for (std::size_t y = 0; y < height; ++y) {
        for (std::size_t x = 0; x < width; ++x) {
            const auto byte = static_cast<unsigned char>(body[y * row_size + x * bits / 8]);
            const std::size_t value = byte >> (8 - bits - x * bits % 8) & ((std::size_t{1} << bits) - 1);
            CCDT_CHECK(value < request.device.sent.size());
        }
    }
}

void check_answer(const api::DeviceRequest& request, const api::Answer& answer) {
    CCDT_CHECK(!answer.partial && !answer.media_type.empty() && answer.pixels > 0);
    const std::string_view format = request.format->file.name;
    if (format == "png") return check_signature(answer.body, "\x89PNG\r\n");
    if (format == "bmp") return check_signature(answer.body, "BM");
    if (format == "escpos") return check_signature(answer.body, "\x1b@\x1dv0");
    check_rows(request, answer.body);
}

void check_request(const api::DeviceRequest& request, const api::Decode& decode) {
    check_cost(api::cost_of(request, kLimits));
    const auto run = [&] {
        api::Timings timings;
        return api::run_device(request, kLimits, decode, {}, timings);
    };
    const auto answer = run();
    if (!answer) return check_error(answer.error());
    check_answer(request, *answer);
    CCDT_CHECK(answer->body == run()->body);
}

}  // namespace
}  // namespace ccdt::fuzz

/// Reads, estimates and answers a request to /halftone for a device. The input is a line with the query, then a
/// picture: an image file, or bytes that determine a picture with extreme values.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace ccdt;
    auto file = fuzz::text_of(data, size);
    const auto options = server::parse_query(fuzz::take_line(file));
    const bool is_image = api::recognise_image(file).has_value();
    const auto input = api::read_halftone(is_image ? file : fuzz::kImage, options, fuzz::kLimits);
    if (!input.has("device")) return 0;
    const auto request = api::parse_device(input, {}, fuzz::kLimits);
    if (request) {
        fuzz::check_request(*request, is_image ? api::decode_inline() : fuzz::decode_of(fuzz::Bytes(file)));
    } else {
        fuzz::check_error(request.error(), options);
    }
    return 0;
}
