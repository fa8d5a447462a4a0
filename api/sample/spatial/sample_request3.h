// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <optional>
#include <span>
#include <stop_token>
#include <string>
#include <string_view>
#include <utility>

#include "api/decode/decode.h"
#include "api/input/negotiation.h"
#include "api/input/option_reader.h"
#include "api/input/point_order.h"
#include "api/input/point_reader.h"
#include "api/input/run_options.h"
#include "api/run/deadline.h"
#include "api/run/stopwatch.h"
#include "api/sample/spatial/point_format3.h"
#include "core/points/order/reorder.h"

namespace ccdt::api {

/// Converts the fields of an error and of its `others`: to JSON Pointers for a JSON body, and otherwise to texts
/// without a slash at the start. A message that begins with such a field is changed, too.
inline Error locate(Error error, bool is_json) {
    std::string& field = error.field;
    if (is_json && !field.empty() && !field.starts_with('/')) field.insert(0, "/");
    if (!is_json && field.starts_with('/')) {
        if (error.message.starts_with(field)) error.message.erase(0, 1);
        field.erase(0, 1);
    }
    for (Error& other : error.others) other = locate(std::move(other), is_json);
    return error;
}

/// Reads the option `crease`, which is in degrees. Returns radians. Errors: Malformed.
inline Result<double> read_crease(const Input& input) {
    constexpr Interval kAngles{.min = 0, .max = 180, .above_min = true};
    return read_number(input, kAngles).map([](double degrees) { return degrees * (std::numbers::pi / 180); });
}

/// Members that requests for points on surfaces and in space, which have three coordinates, share. A request also has
/// the function formats(), which returns the formats of its answer.
/// @tparam Run     options of the distribution
/// @tparam Points  placed points: PlacedSurface or PlacedVolume
template <class Run, class Points>
struct SampleRequest3 {
    using Placed = Points;

    Run run;
    std::optional<double> crease;         ///< angle above which an edge of the mesh is a crease, radians
    PointOrder order = PointOrder::None;  ///< not Path
    OnStop on_deadline = OnStop::Error;
    const PointFormat3<Placed>* format = nullptr;  ///< never null in a parsed request
    bool is_json = false;                          ///< whether options are members of a JSON body

    /// Converts an error about an option, such as `fixed/3`: if the body is JSON, Error::field becomes a JSON Pointer;
    /// otherwise it begins with the name of the option.
    Error located(Error error) const { return locate(std::move(error), is_json); }
};

/// Adds the rules of the options that requests for points on surfaces and in space share. The first one is that of
/// `crease`, which only meshes have.
/// @tparam Request  a type derived from SampleRequest3
template <class Request, std::size_t kOwn>
constexpr std::array<OptionRule<Request>, kOwn + 7> with_shared_rules(
    const std::array<OptionRule<Request>, kOwn>& own) {
    std::array<OptionRule<Request>, kOwn + 7> rules{{
        {"crease", [](const Input& i, const Limits&, Request& r) { return assign(r.crease, read_crease(i)); }},
        {"sites", [](const Input& i, const Limits& l, Request& r) { return assign(r.run.sites, read_sites(i, l)); }},
        {"seed", [](const Input& i, const Limits&, Request& r) { return read_seed(i, r.run); }},
        {"on_deadline",
         [](const Input& i, const Limits&, Request& r) { return assign(r.on_deadline, read_on_deadline(i)); }},
        {"fixed", [](const Input& i, const Limits& l, Request& r) { return assign(r.run.fixed, read_points3(i, l)); }},
        {"order", [](const Input& i, const Limits&, Request& r) { return assign(r.order, read_point_order3(i)); }},
        {"mesh", [](const Input& i, const Limits&, Request& r) { return assign(r.run.keep_mesh, read_boolean(i)); }},
    }};
    std::ranges::copy(own, rules.end() - kOwn);
    return rules;
}

/// Chooses the format of the answer. Errors: those of negotiate() and check_mesh().
template <class Request>
Result<void> settle_format(std::string_view accept, Request& request) {
    return settle_format(accept, Request::formats(), request.format).and_then([&] {
        return check_mesh(*request.format, request.run.keep_mesh);
    });
}

/// Writes placed points in the requested format, or in another one.
///
/// @param placed  result of place_sample3() for `request`
/// @param sink    as for run_sample3()
/// Errors: those of the format; Malformed if the format needs the triangulation, and the request does not ask for it.
template <class Run, class Placed>
Result<Answer> write_answer(const SampleRequest3<Run, Placed>& request, const Placed& placed,
                            const PointFormat3<Placed>& format, const Control& control, Timings& timings,
                            BodySink* sink = nullptr) {
    const auto located = [&](Error error) { return request.located(std::move(error)); };
    Stopwatch watch;
    if (auto can = check_mesh(format, request.run.keep_mesh).map_error(located); !can)
        return tl::unexpected(can.error());
    Answer answer;
    answer.media_type = format.file.content_type();
    answer.repeats = format.repeats;
    answer.sites = placed.size();
    answer.partial = placed.dots.stopped;
    if (format.file.name != "json") {
        answer.repaired = header_of(placed.repairs);
        answer.warnings = header_of(placed.warnings);
    }
    const std::stop_token stop = stop_of_writing(control, request.on_deadline);
    Body body(answer, sink, control.stop);
    auto written = format.writer(request.run.keep_mesh)(placed, body, stop);
    if (written) written = check_stop(stop);
    timings.encode = watch.lap();
    if (!written) return tl::unexpected(located(written.error()));
    return body.finish(std::move(answer)).map_error(located);
}

/// Distributes points on a surface or in space, and writes them in the requested format.
///
/// @param control  a requested stop ends the run within one pass over the points
/// @param sink     receives the body in pieces if the body is larger than Body::kMaxInMemory; null: the answer contains
///                 the whole body
/// @returns        the answer; without its body if the sink received the body
/// Errors: those of place_sample3() and of the format; LimitExceeded if the answer is too large for the format;
/// Stopped, unless points are already placed and the request accepts a partial result. The same request gives the same
/// bytes, except for `elapsed_ms` in JSON.
template <class Request>
Result<Answer> run_sample3(const Request& request, const Decode& decode, const Control& control, Timings& timings,
                           BodySink* sink = nullptr) {
    const auto placed = place_sample3(request, decode, control, timings);
    if (!placed) return tl::unexpected(placed.error());
    return write_answer(request, *placed, *request.format, control, timings, sink);
}

/// Puts points on a surface or in space into a progressive order, and sets their ranks.
/// @param order  result of progressive_order_on_surface() or progressive_order_in_space()
template <class AnyDistribution>
void set_order(AnyDistribution& dots, std::span<const std::uint32_t> order, const std::stop_token& stop) {
    reorder(dots, order);
    dots.ranks.resize(dots.points.size());
    std::iota(dots.ranks.begin(), dots.ranks.end(), std::uint32_t{0});
    dots.stopped = dots.stopped || stop.stop_requested();
}

}  // namespace ccdt::api
