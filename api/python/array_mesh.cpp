// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/python/array_mesh.h"

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include <pybind11/numpy.h>

#include "core/picture/srgb.h"

namespace ccdt::python {
namespace {

namespace py = pybind11;

/// Returns the rows of an array.
template <class Value, std::size_t kColumns>
std::span<const std::array<Value, kColumns>> rows_of(const py::handle& object) {
    const auto array = py::cast<py::array>(object);
    return {static_cast<const std::array<Value, kColumns>*>(array.data()), static_cast<std::size_t>(array.shape(0))};
}

tl::unexpected<Error> wrong(std::string_view name, std::size_t row, const std::string& what) {
    const std::string field = std::string(name) + '/' + std::to_string(row);
    return failure(ErrorCode::Malformed, field + ' ' + what, field);
}

}  // namespace

Result<TriangleSoup> soup_of(const py::tuple& arrays) {
    TriangleSoup soup;
    for (const auto& [x, y, z] : rows_of<double, 3>(arrays[0])) soup.vertices.push_back({x, y, z});
    for (const auto& row : rows_of<std::int64_t, 3>(arrays[1])) {
        auto& corners = soup.triangles.emplace_back();
        for (std::size_t i = 0; i < row.size(); ++i) {
            if (row[i] < 0 || static_cast<std::size_t>(row[i]) >= soup.vertices.size())
                return wrong("triangles", soup.triangles.size() - 1,
                             "must have indices of vertices, from 0 to " +
                                 std::to_string(std::int64_t(soup.vertices.size()) - 1));
            corners[i] = static_cast<std::uint32_t>(row[i]);
        }
    }
    for (const auto& row : rows_of<double, 3>(arrays[2])) {
        auto& colour = soup.colours.emplace_back();
        for (std::size_t i = 0; i < row.size(); ++i) {
            if (!(row[i] >= 0 && row[i] <= 1))
                return wrong("colors", soup.colours.size() - 1, "must have values from 0 to 1");
            colour[i] = static_cast<float>(light_of_srgb(row[i]));
        }
    }
    for (const auto& [s, t] : rows_of<double, 2>(arrays[3]))
        soup.texture.push_back({static_cast<float>(s), static_cast<float>(t)});
    return soup;
}

}  // namespace ccdt::python
