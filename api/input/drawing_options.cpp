#include "api/input/drawing_options.h"

#include <array>

namespace ccdt::api {
namespace {

constexpr Interval kWidths = {.min = 1, .max = 10'000};
constexpr std::array<Choice<DotStyle>, 2> kStyles = {{{"fill", DotStyle::Fill}, {"stroke", DotStyle::Stroke}}};

}  // namespace

Result<void> read_width_mm(const Input& input, DrawingOptions& options) {
    return assign(options.width_mm, read_number(input, kWidths));
}

Result<void> read_style(const Input& input, DrawingOptions& options) {
    return assign(options.style, read_choice<DotStyle>(input, kStyles));
}

}  // namespace ccdt::api
