// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "api/input/option_reader.h"
#include "core/base/result.h"
#include "core/ccdt/volume/box_domain3.h"
#include "core/geometry/domain.h"

namespace ccdt::api {

/// Domain [0, width] x [0, height].
struct Rectangle {
    double width = 0;
    double height = 0;
    bool periodic = false;  ///< whether the domain is a torus, whose opposite sides are joined
};

/// Reads the member `domain`: `{"type":"rectangle"|"torus","width":w,"height":h}`.
/// Errors: Malformed, with a JSON Pointer to the faulty value.
Result<Rectangle> read_rectangle(const Input& input);

/// Whether a domain is an object that read_box() reads: it is of the type box, or has a depth.
bool is_box(JsonValue domain);

/// Reads a domain in space: `{"type":"box"|"torus","width":w,"height":h,"depth":d}`. Errors: as read_rectangle().
Result<BoxDomain3> read_box(const Input& input);

/// Creates the domain. Errors: those of Domain::rectangle and Domain::torus, with the field /domain.
Result<Domain> make_domain(const Rectangle& rectangle);

}  // namespace ccdt::api
