#pragma once

#include <optional>

#include "api/input/option_reader.h"
#include "core/result.h"

namespace ccdt::api {

/// Shape of a dot in SVG.
enum class DotStyle {
    Fill,    ///< a disc
    Stroke,  ///< a stroke as wide as the dot and next to no length, for plotters: the pen goes down and up
};

/// Options of drawings that every endpoint shares.
struct DrawingOptions {
    std::optional<double> width_mm;  ///< of the page; none: only pixels are told
    DotStyle style = DotStyle::Fill;
};

/// Reads an option of its member's name. Errors: Malformed.
Result<void> read_width_mm(const Input& input, DrawingOptions& options);
Result<void> read_style(const Input& input, DrawingOptions& options);

}  // namespace ccdt::api
