// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/sample/pixels/pixel_sample.h"

#include <algorithm>
#include <vector>

#include "tests/fuzz/answer_checks.h"
#include "tests/fuzz/extreme_pictures.h"

namespace ccdt::fuzz {
namespace {

constexpr api::Limits kLimits = {.max_sites = 64, .max_pixels = 2'048};

/// Returns the marks of the pixels in a NumPy array.
std::vector<std::uint8_t> marks_of_npy(std::string_view body) {
    check_signature(body, "\x93NUMPY");
    body.remove_prefix(body.find('\n') + 1);
    return {body.begin(), body.end()};
}

void check_answer(const api::PixelRequest& request, const api::Answer& answer) {
    CCDT_CHECK(!answer.partial && !answer.media_type.empty() && answer.sites == request.sites);
    const std::string_view format = request.format->file.name;
    if (format == "png") return check_signature(answer.body, "\x89PNG\r\n");
    if (format == "json") return check_json(answer.body);
    if (format == "csv") {
        CCDT_CHECK(points_of_csv(answer.body).size() == request.sites);
        return;
    }
    const auto& [width, height] = request.raster;
    const std::vector<std::uint8_t> marks = marks_of_npy(answer.body);
    CCDT_CHECK(marks.size() == static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    CCDT_CHECK(static_cast<std::size_t>(std::ranges::count(marks, 1)) == request.sites);
    CCDT_CHECK(static_cast<std::size_t>(std::ranges::count(marks, 0)) == marks.size() - request.sites);
    for (const auto& [left, low, right, high] : request.included) {
        for (const int y : {low, high - 1}) {
            for (const int x : {left, right - 1})
                CCDT_CHECK(marks[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                                 static_cast<std::size_t>(x)] == 1);
        }
    }
}

void check_request(const api::PixelRequest& request, std::string_view body) {
    check_cost(api::cost_of(request, kLimits));
    const auto decode = decode_of(Bytes(body));
    const auto run = [&] {
        api::Timings timings;
        return api::run_pixels(request, kLimits, decode, {}, timings);
    };
    const auto answer = run();
    if (!answer) return check_error(answer.error(), body);
    check_answer(request, *answer);
    CCDT_CHECK(answer->body == run()->body);
}

}  // namespace
}  // namespace ccdt::fuzz

/// Reads, estimates and answers a request to /sample for a set of pixels. The input is the JSON body. If its density is
/// an image, the bytes of the body determine the picture.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace ccdt;
    const auto body = fuzz::text_of(data, size);
    const auto document = api::JsonDocument::parse(body);
    if (!document || !api::asks_for_pixels(document->root())) return 0;
    const auto request = api::parse_pixels(document->root(), {}, {}, fuzz::kLimits);
    if (request) {
        fuzz::check_request(*request, body);
    } else {
        fuzz::check_error(request.error(), body);
    }
    return 0;
}
