// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/image/decoder_warm_up.h"

#include <array>
#include <string_view>

#include "api/image/embedded_image.h"
#include "api/image/image_codec.h"

namespace ccdt::api {
namespace {

/// Pictures of one pixel, in base64: a PNG, a JPEG, a lossy WebP, a lossless WebP, a TIFF and an AVIF.
constexpr std::array<std::string_view, 6> kPixels = {
    "iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAAAAAA6fptVAAAACklEQVR4nGNgAAAAAgABSK+kcQAAAABJRU5ErkJggg==",
    "/9j/4AAQSkZJRgABAQAAAQABAAD/2wBDAAgGBgcGBQgHBwcJCQgKDBQNDAsLDBkSEw8UHRofHh0aHBwgJC4nICIsIxwcKDcpLDAxNDQ0Hyc5"
    "PTgyPC4zNDL/wAALCAABAAEBAREA/8QAFAABAAAAAAAAAAAAAAAAAAAACP/EABQQAQAAAAAAAAAAAAAAAAAAAAD/2gAIAQEAAD8AP7//2Q==",
    "UklGRiQAAABXRUJQVlA4IBgAAAAwAQCdASoBAAEAAsBMJaQAA3AA/vgfgAA=",
    "UklGRhoAAABXRUJQVlA4TA4AAAAvAAAAAAcQEf0PRET/Aw==",
    "SUkqAAgAAAAJAAABBAABAAAAAQAAAAEBBAABAAAAAQAAAAIBAwABAAAACAAAAAMBAwABAAAAAQAAAAYBAwABAAAAAQAAABEBBAABAAAAegAAABYB"
    "BAABAAAAAQAAABcBBAABAAAAAQAAABwBAwABAAAAAQAAAAAAAAAA",
    "AAAAIGZ0eXBhdmlmAAAAAGF2aWZtaWYxbWlhZk1BMUIAAADybWV0YQAAAAAAAAAoaGRscgAAAAAAAAAAcGljdAAAAAAAAAAAAAAAAGxpYmF2aWYAAA"
    "AA"
    "DnBpdG0AAAAAAAEAAAAeaWxvYwAAAABEAAABAAEAAAABAAABGgAAABoAAAAoaWluZgAAAAAAAQAAABppbmZlAgAAAAABAABhdjAxQ29sb3IAAAAAam"
    "lw"
    "cnAAAABLaXBjbwAAABRpc3BlAAAAAAAAAAEAAAABAAAAEHBpeGkAAAAAAwgICAAAAAxhdjFDgQAMAAAAABNjb2xybmNseAABAA0ABoAAAAAXaXBtYQ"
    "AA"
    "AAAAAAABAAEEAQKDBAAAACJtZGF0EgAKCBgABggIaDQgMgwWQAYYYYQAAHlM0co=",
};

}  // namespace

void warm_up_decoder() {
    for (const std::string_view pixel : kPixels) {
        if (const auto file = decode_base64(pixel)) static_cast<void>(decode_image(*file, 1));
    }
}

}  // namespace ccdt::api
