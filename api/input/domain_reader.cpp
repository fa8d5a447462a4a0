// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/input/domain_reader.h"

#include <array>
#include <optional>
#include <span>

namespace ccdt::api {
namespace {

struct Members {
    std::optional<bool> periodic;
    Point3 sides;
};

constexpr std::array<Choice<bool>, 2> kFlat = {{{"rectangle", false}, {"torus", true}}};
constexpr std::array<Choice<bool>, 2> kInSpace = {{{"box", false}, {"torus", true}}};

/// The rules of a domain in the plane, then one more for a domain in space.
template <const std::array<Choice<bool>, 2>& kTypes>
constexpr std::array<OptionRule<Members>, 4> kRules = {{
    {"/domain/type",
     [](const Input& i, const Limits&, Members& m) { return assign(m.periodic, read_choice<bool>(i, kTypes)); }},
    {"/domain/width",
     [](const Input& i, const Limits&, Members& m) { return assign(m.sides.x, read_number(i, kPositive)); }},
    {"/domain/height",
     [](const Input& i, const Limits&, Members& m) { return assign(m.sides.y, read_number(i, kPositive)); }},
    {"/domain/depth",
     [](const Input& i, const Limits&, Members& m) { return assign(m.sides.z, read_number(i, kPositive)); }},
}};

Result<Members> read_domain(const Input& input, std::span<const OptionRule<Members>> rules) {
    Members members;
    const auto object = std::get<JsonValue>(input.value);
    return read_members<Members>(rules, object, input.field, {}, members).map([&] { return members; });
}

}  // namespace

Result<Rectangle> read_rectangle(const Input& input) {
    return read_domain(input, std::span(kRules<kFlat>).first(3)).and_then([&](const Members& m) -> Result<Rectangle> {
        if (m.periodic && m.sides.x > 0 && m.sides.y > 0) return Rectangle{m.sides.x, m.sides.y, *m.periodic};
        return malformed(input, "must have the members type, width and height");
    });
}

bool is_box(JsonValue domain) {
    if (!domain.is_object()) return false;
    const auto type = domain.find("type");
    return domain.find("depth") || (type && type->is_string() && type->text() == "box");
}

Result<BoxDomain3> read_box(const Input& input) {
    return read_domain(input, kRules<kInSpace>).and_then([&](const Members& m) -> Result<BoxDomain3> {
        if (m.periodic && m.sides.x > 0 && m.sides.y > 0 && m.sides.z > 0) return BoxDomain3{m.sides, *m.periodic};
        return malformed(input, "must have the members type, width, height and depth");
    });
}

Result<Domain> make_domain(const Rectangle& rectangle) {
    auto domain = rectangle.periodic ? Domain::torus(rectangle.width, rectangle.height)
                                     : Domain::rectangle(rectangle.width, rectangle.height);
    if (!domain) domain.error().field = "/domain";
    return domain;
}

}  // namespace ccdt::api
