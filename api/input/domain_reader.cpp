// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/input/domain_reader.h"

#include <array>
#include <optional>

namespace ccdt::api {
namespace {

struct Members {
    std::optional<bool> periodic;
    Rectangle sides;
};

constexpr std::array<Choice<bool>, 2> kPeriodic = {{{"rectangle", false}, {"torus", true}}};

constexpr std::array<OptionRule<Members>, 3> kRules = {{
    {"/domain/type",
     [](const Input& i, const Limits&, Members& m) { return assign(m.periodic, read_choice<bool>(i, kPeriodic)); }},
    {"/domain/width",
     [](const Input& i, const Limits&, Members& m) { return assign(m.sides.width, read_number(i, kPositive)); }},
    {"/domain/height",
     [](const Input& i, const Limits&, Members& m) { return assign(m.sides.height, read_number(i, kPositive)); }},
}};

}  // namespace

Result<Rectangle> read_rectangle(const Input& input) {
    Members members;
    const auto object = std::get<JsonValue>(input.value);
    if (auto read = read_members<Members>(kRules, object, input.field, {}, members); !read) {
        return tl::unexpected(read.error());
    }
    if (!members.periodic || members.sides.width == 0 || members.sides.height == 0) {
        return malformed(input, "must have the members type, width and height");
    }
    members.sides.periodic = *members.periodic;
    return members.sides;
}

Result<Domain> make_domain(const Rectangle& rectangle) {
    auto domain = rectangle.periodic ? Domain::torus(rectangle.width, rectangle.height)
                                     : Domain::rectangle(rectangle.width, rectangle.height);
    if (!domain) domain.error().field = "/domain";
    return domain;
}

}  // namespace ccdt::api
