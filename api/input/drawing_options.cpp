#include "api/input/drawing_options.h"

#include <algorithm>
#include <array>
#include <string_view>

namespace ccdt::api {
namespace {

constexpr Interval kWidths = {.min = 1, .max = 10'000};
constexpr Interval kPens = {.min = 0.01, .max = 100};

constexpr std::array<Choice<DotStyle>, 5> kStyles = {{{"fill", DotStyle::Fill},
                                                      {"stroke", DotStyle::Stroke},
                                                      {"circles", DotStyle::Circles},
                                                      {"spiral", DotStyle::Spiral},
                                                      {"path", DotStyle::Path}}};

}  // namespace

std::string_view name_of(DotStyle style) {
    return std::ranges::find(kStyles, style, &Choice<DotStyle>::value)->word;
}

Result<void> read_width_mm(const Input& input, DrawingOptions& options) {
    return assign(options.width_mm, read_number(input, kWidths));
}

Result<void> read_style(const Input& input, DrawingOptions& options) {
    return assign(options.style, read_choice<DotStyle>(input, kStyles));
}

Result<void> read_pen(const Input& input, DrawingOptions& options) {
    constexpr std::string_view kUnit = "mm";
    Input number = input;
    if (const auto text = read_text(input); text && text->ends_with(kUnit))
        number.value = text->substr(0, text->size() - kUnit.size());
    return assign(options.pen_mm, read_number(number, kPens));
}

}  // namespace ccdt::api
