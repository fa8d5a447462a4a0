// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/input/point_order.h"

namespace ccdt::api {

Result<PointOrder> read_point_order(const Input& input) {
    static constexpr Choice<PointOrder> kWords[] = {
        {"none", PointOrder::None}, {"path", PointOrder::Path}, {"progressive", PointOrder::Progressive}};
    return read_choice<PointOrder>(input, kWords);
}

Result<PointOrder> read_point_order3(const Input& input) {
    static constexpr Choice<PointOrder> kWords[] = {{"none", PointOrder::None},
                                                    {"progressive", PointOrder::Progressive}};
    if (const auto text = read_text(input); text && *text == "path")
        return malformed(
            input, "cannot be 'path' for points on a surface or in space, because paths are for drawings in the plane");
    return read_choice<PointOrder>(input, kWords);
}

}  // namespace ccdt::api
