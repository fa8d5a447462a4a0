// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/output/pen_labels.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <string_view>

#include "api/text/text.h"

namespace ccdt::api {
namespace {

struct NamedColour {
    std::string_view name;
    Colour colour;
};

constexpr std::array<NamedColour, 20> kNamed = {{
    {"black", kBlack},         {"gray", {128, 128, 128}}, {"silver", {192, 192, 192}},   {"white", kWhite},
    {"red", {255, 0, 0}},      {"maroon", {128, 0, 0}},   {"brown", {139, 69, 19}},      {"orange", {255, 165, 0}},
    {"yellow", {255, 255, 0}}, {"olive", {128, 128, 0}},  {"green", {0, 128, 0}},        {"lime", {0, 255, 0}},
    {"teal", {0, 128, 128}},   {"cyan", {0, 255, 255}},   {"sky blue", {135, 206, 235}}, {"blue", {0, 0, 255}},
    {"navy", {0, 0, 128}},     {"purple", {128, 0, 128}}, {"magenta", {255, 0, 255}},    {"pink", {255, 192, 203}},
}};

/// Returns the name of the nearest colour, by the squared distance in sRGB.
std::string_view nearest_colour_name(const Colour& colour) {
    const auto distance = [&](const NamedColour& other) { return squared_distance(colour, other.colour); };
    return std::ranges::min_element(kNamed, {}, distance)->name;
}

std::string without_digits(std::string name) {
    std::erase_if(name, [](char c) { return c >= '0' && c <= '9'; });
    return std::string(trim(name));
}

std::string label_of(const Ink& ink) {
    if (ink.name.empty()) return "dots";
    if (ink.name == hexadecimal(ink.colour)) return std::string(nearest_colour_name(ink.colour));
    std::string label = without_digits(ink.name);
    return label.empty() ? std::string(nearest_colour_name(ink.colour)) : label;
}

}  // namespace

std::vector<std::string> pen_labels(std::span<const Ink> inks) {
    std::vector<std::string> plain;
    for (const Ink& ink : inks) plain.push_back(label_of(ink));
    std::vector<std::string> labels;
    for (std::size_t i = 0; i < plain.size(); ++i) {
        const auto before = std::count(plain.begin(), plain.begin() + static_cast<std::ptrdiff_t>(i), plain[i]);
        const bool repeated = std::ranges::count(plain, plain[i]) > 1;
        labels.push_back(repeated ? plain[i] + ' ' + static_cast<char>('A' + before) : plain[i]);
    }
    return labels;
}

}  // namespace ccdt::api
