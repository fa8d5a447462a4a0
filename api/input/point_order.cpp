// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/input/point_order.h"

namespace ccdt::api {

Result<PointOrder> read_point_order(const Input& input) {
    static constexpr Choice<PointOrder> kWords[] = {
        {"none", PointOrder::None}, {"path", PointOrder::Path}, {"progressive", PointOrder::Progressive}};
    return read_choice<PointOrder>(input, kWords);
}

}  // namespace ccdt::api
