#include "api/input/drawing_options.h"

#include <array>
#include <string_view>

namespace ccdt::api {
namespace {

constexpr Interval kWidths = {.min = 1, .max = 10'000};

}  // namespace

Result<void> read_width_mm(const Input& input, DrawingOptions& options) {
    return assign(options.width_mm, read_number(input, kWidths));
}

Result<void> read_style(const Input& input, DrawingOptions& options) {
    static constexpr std::array<std::string_view, 2> kWords = {"fill", "stroke"};
    return assign(options.style, read_choice(input, kWords));
}

}  // namespace ccdt::api
