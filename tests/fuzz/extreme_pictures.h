// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "api/image/image_codec.h"
#include "tests/fuzz/checks.h"

namespace ccdt::fuzz {

/// What "decodes" any file to one small picture: in grey or in colour, opaque or not, with values at the ends of their
/// ranges or beyond them, mostly of one kind with an exception here and there.
///
/// @param input  what is left of it is the picture
api::Decode decode_of(Bytes input);

}  // namespace ccdt::fuzz
