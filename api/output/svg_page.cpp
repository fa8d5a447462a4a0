// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/output/svg_page.h"

#include <algorithm>
#include <cmath>

#include "api/text/numbers.h"
#include "core/base/elementary.h"

namespace ccdt::api {

int svg_decimals(const Page& page) {
    constexpr int kDigits = 6, kMaxDecimals = 300;
    const double longer = std::max(page.size().x, page.size().y);
    return std::clamp(kDigits - static_cast<int>(std::floor(elementary::log10(longer))), 0, kMaxDecimals);
}

void begin_svg(const Page& page, std::string_view attributes, Body& body) {
    const int decimals = svg_decimals(page);
    std::string width, height;
    append_rounded(width, page.size().x, decimals);
    append_rounded(height, page.size().y, decimals);
    std::string& out = body.text();
    out.append(R"(<svg xmlns="http://www.w3.org/2000/svg")").append(attributes).append(R"( width=")");
    if (page.width_mm) {
        out.append(width).append(R"(mm" height=")").append(height).append("mm");
    } else {
        out.append(std::to_string(page.canvas.width)).append(R"(" height=")");
        out.append(std::to_string(page.canvas.height));
    }
    out.append(R"(" viewBox="0 0 )").append(width).append(" ").append(height).append("\">\n");
}

std::string escaped(std::string_view text) {
    std::string out;
    for (const char c : text) {
        switch (c) {
            case '&':
                out += "&amp;";
                break;
            case '<':
                out += "&lt;";
                break;
            case '"':
                out += "&quot;";
                break;
            default:
                // XML 1.0 cannot represent control characters.
                out += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
        }
    }
    return out;
}

}  // namespace ccdt::api
