// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/input/picture_options.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <string_view>

namespace ccdt::api {

Result<Fit> read_fit(const Input& input) {
    static constexpr std::array<Choice<Fit>, 2> kFits = {{{"contain", Fit::Contain}, {"cover", Fit::Cover}}};
    return read_choice<Fit>(input, kFits);
}

Result<Focus> read_gravity(const Input& input) {
    static constexpr std::array kShares = {&Focus::x, &Focus::y};
    auto parts = read_list(input, kShares.size(), "value");
    if (!parts) return tl::unexpected(parts.error());
    if (parts->size() < kShares.size()) return malformed(input, "must be two numbers from 0 to 1, such as 0.5,0.2");
    Focus focus;
    for (std::size_t i = 0; i < kShares.size(); ++i) {
        if (auto read = assign(focus.*kShares[i], read_number((*parts)[i], {.min = 0, .max = 1})); !read)
            return tl::unexpected(read.error());
    }
    return focus;
}

Result<void> check_gravity(std::span<const Input> options, Fit fit) {
    const auto gravity = std::ranges::find(options, "gravity", &Input::name);
    if (gravity == options.end() || fit == Fit::Cover) return {};
    return malformed(*gravity, "needs fit=cover");
}

Result<AlphaMixing> read_alpha(const Input& input) {
    static constexpr std::array<Choice<AlphaMixing>, 2> kMixings = {
        {{"display", AlphaMixing::Display}, {"linear", AlphaMixing::Linear}}};
    return read_choice<AlphaMixing>(input, kMixings);
}

Result<int> read_side(const Input& input) {
    constexpr std::uint64_t kMaxSide = 65'535;
    return read_integer(input, 1, kMaxSide).map([](std::uint64_t side) { return static_cast<int>(side); });
}

Result<Levels> read_levels(const Input& input) {
    struct Level {
        std::string_view name;
        double Levels::*value;
        Interval allowed;
    };
    static constexpr std::array<Level, 3> kLevels = {{{"black point", &Levels::black, {.min = 0, .max = 1}},
                                                      {"white point", &Levels::white, {.min = 0, .max = 1}},
                                                      {"gamma", &Levels::gamma, {.min = 0.1, .max = 10}}}};
    Levels levels;
    auto parts = read_list(input, kLevels.size(), "value");
    if (!parts) return tl::unexpected(parts.error());
    if (parts->size() < 2)
        return malformed(input, "must be a black point and a white point, both from 0 to 1, and optionally gamma");
    for (std::size_t i = 0; i < parts->size(); ++i) {
        Input& part = (*parts)[i];
        part.name = input.name + ": " + std::string(kLevels[i].name);
        if (auto read = assign(levels.*kLevels[i].value, read_number(part, kLevels[i].allowed)); !read)
            return tl::unexpected(read.error());
    }
    if (levels.black < levels.white) return levels;
    return malformed(input, "must have a black point below the white point");
}

}  // namespace ccdt::api
