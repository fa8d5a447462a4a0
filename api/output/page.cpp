// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/output/page.h"

#include <algorithm>
#include <string>
#include <utility>

#include "api/text/numbers.h"

namespace ccdt::api {
namespace {

constexpr double kMinGap = 4;  ///< smallest distance of the drawing from the edges of paper with marks, mm

void append_sides(std::string& text, Point sides) {
    append_rounded(text, sides.x, 2);
    append_rounded(text += " x ", sides.y, 2);
    text += " mm";
}

}  // namespace

std::vector<MarkLine> Page::marks() const {
    constexpr double kLongest = 4, kShare = 0.4;  // of an arm, in mm and in distances between drawing and paper
    if (!sheet || !sheet->marks) return {};
    const Box area = drawing();
    const Point gap{sheet->size.x - area.max.x, sheet->size.y - area.max.y};  // the same on opposite sides
    const double arm = std::min(kLongest, kShare * std::min(gap.x, gap.y));
    std::vector<MarkLine> lines;
    for (const double x : {area.min.x - gap.x / 2, area.max.x + gap.x / 2}) {
        for (const double y : {area.min.y - gap.y / 2, area.max.y + gap.y / 2}) {
            lines.push_back({{x - arm, y}, {x + arm, y}});
            lines.push_back({{x, y - arm}, {x, y + arm}});
        }
    }
    return lines;
}

Result<void> place_on_paper(const DrawingOptions& options, Page& page) {
    page.width_mm = options.width_mm;
    if (!options.paper) return {};
    const auto fault = [](std::string_view option, std::string message) {
        return failure(ErrorCode::Unusable, std::move(message), std::string(option));
    };
    Point paper = *options.paper;
    const Box& box = page.box;
    if ((box.width() > box.height()) != (paper.x > paper.y)) std::swap(paper.x, paper.y);
    const Point room = paper - Point{2 * options.margin, 2 * options.margin};
    if (std::min(room.x, room.y) < 1) {
        std::string message = "margin leaves no room on paper of ";
        append_sides(message, paper);
        return fault("margin", std::move(message));
    }
    if (!page.width_mm) page.width_mm = std::min(room.x, room.y * box.width() / box.height());
    const Point sides = page.drawing().max;
    constexpr double kRounding = 1e-6;
    if (sides.x > room.x + kRounding || sides.y > room.y + kRounding) {
        std::string message = "width_mm makes a drawing of ";
        append_sides(message, sides);
        append_sides(message += "; the paper has room for ", room);
        return fault("width_mm", std::move(message));
    }
    page.sheet = Sheet{paper, 0.5 * (paper - sides), options.marks};
    if (options.marks && std::min(page.sheet->corner.x, page.sheet->corner.y) < kMinGap)
        return fault("marks", "marks need a margin of at least 4 mm");
    return {};
}

}  // namespace ccdt::api
