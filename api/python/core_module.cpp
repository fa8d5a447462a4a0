// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include "api/analyze/analyze.h"
#include "api/analyze/surface_analyze.h"
#include "api/halftone/device_picture.h"
#include "api/halftone/halftone.h"
#include "api/operation/parsed_request.h"
#include "api/output/file_writer.h"
#include "api/python/array_mesh.h"
#include "api/python/array_picture.h"
#include "api/python/decode_capsule.h"
#include "api/python/interruptible.h"
#include "api/python/png_pixels.h"
#include "api/sample/pixels/pixel_sample.h"
#include "api/sample/plane/sample.h"
#include "api/sample/plane/sample_parser.h"
#include "api/sample/spatial/surface_sample.h"
#include "api/sample/spatial/volume_sample.h"
#include "api/text/numbers.h"

namespace ccdt::python {
namespace {

namespace py = pybind11;

using OptionList = std::vector<std::pair<std::string, std::string>>;

/// Settings of a computation that do not change its result.
struct Running {
    std::size_t threads = 1;
    py::object progress;  ///< see run_interruptible()
};

const char* name_of(ErrorCode code) {
    switch (code) {
        case ErrorCode::Malformed:
            return "malformed";
        case ErrorCode::Unusable:
            return "unusable";
        case ErrorCode::LimitExceeded:
            return "limit_exceeded";
        case ErrorCode::NotAcceptable:
            return "not_acceptable";
        case ErrorCode::Unsupported:
            return "unsupported";
        case ErrorCode::Unavailable:
            return "unavailable";
        case ErrorCode::Stopped:
            return "stopped";
        case ErrorCode::Internal:
            break;
    }
    return "internal";
}

/// Raises ccdt.Error.
[[noreturn]] void raise(const Error& error) {
    const py::object type = py::module_::import("ccdt.errors").attr("Error");
    std::vector<std::pair<std::string, std::string>> all{{error.field, error.message}};
    for (const Error& other : error.others) all.emplace_back(other.field, other.message);
    const py::object raised = type.attr("_of")(name_of(error.code), all);
    PyErr_SetObject(type.ptr(), raised.ptr());
    throw py::error_already_set();
}

template <class T>
T value_or_raise(Result<T> result) {
    if (!result) raise(result.error());
    return *std::move(result);
}

std::vector<api::TextOption> text_options(const OptionList& options) {
    std::vector<api::TextOption> list;
    list.reserve(options.size());
    for (const auto& [name, value] : options) list.push_back({name, value});
    return list;
}

/// Returns the decoders of ccdt._codec, which this function loads.
const api::Decode& file_decode() {
    const py::capsule capsule = py::module_::import("ccdt._codec").attr("decode");
    return *static_cast<const api::Decode*>(PyCapsule_GetPointer(capsule.ptr(), kDecodeCapsule));
}

/// Picture of a request: an array of pixels, or the bytes of a file.
class PictureInput {
public:
    /// @param picture  bytes, or an array as in decode_array()
    PictureInput(py::object picture, bool linear)
        : picture_(std::move(picture)), decode_(decoders(linear)), file_(read_header()) {}

    api::HalftoneInput with(const std::vector<api::TextOption>& options) const {
        return api::read_halftone(file_, options);
    }
    const api::Limits& limits() const { return limits_; }
    const api::Decode& decode() const { return decode_; }

private:
    bool is_file() const { return py::isinstance<py::bytes>(picture_); }
    py::array pixels() const { return py::cast<py::array>(picture_); }

    api::Decode decoders(bool linear) const { return is_file() ? file_decode() : decode_array(pixels(), linear); }

    Result<api::ImageFile> read_header() const {
        if (!is_file()) return file_of(pixels(), limits_.max_pixels);
        const std::string_view bytes = py::reinterpret_borrow<py::bytes>(picture_);
        const auto with_bytes = [&](const api::ImageHeader& header) { return api::ImageFile{bytes, header}; };
        return api::read_image_header(bytes, limits_.max_pixels).map(with_bytes);
    }

    api::Limits limits_;
    py::object picture_;  ///< owns the memory to which the other members refer
    api::Decode decode_;
    Result<api::ImageFile> file_;
};

/// Finds a format by name. Throws ccdt.Error if the endpoint does not have it.
template <class Format>
const Format& format_of(std::span<const Format* const> formats, std::string_view name) {
    const auto found = std::ranges::find(formats, name, [](const Format* each) { return each->file.name; });
    if (found != formats.end()) return **found;
    std::string names;
    for (const Format* each : formats) names.append(names.empty() ? "" : ", ").append(each->file.name);
    raise({ErrorCode::NotAcceptable, "format " + std::string(name) + " is not one of " + names, "format"});
}

/// An answer that Python owns. Python reads its bytes by the buffer protocol, without a copy.
using AnswerPointer = std::unique_ptr<api::Answer>;

AnswerPointer keep(Result<api::Answer> answer) {
    return std::make_unique<api::Answer>(value_or_raise(std::move(answer)));
}

/// Calls compute(control, timings), which Python can interrupt.
template <class Compute>
auto run(const Running& running, Compute compute) {
    return run_interruptible(running.threads, running.progress, [&](const Control& control) {
        api::Timings timings;
        return compute(control, timings);
    });
}

/// Dots that are placed, with the request that asked for them.
class Halftone {
public:
    Halftone(py::object picture, bool linear, const OptionList& options, const Running& running)
        : input_(std::move(picture), linear), request_(parsed(options)), placed_(value_or_raise(placed(running))) {}

    AnswerPointer write(const std::string& format, const Running& running) const {
        const api::PointFormat& chosen = format.empty() ? *request_.format : format_of(api::halftone_formats(), format);
        return keep(run(running, [&](const Control& control, api::Timings& timings) {
            return api::write_answer(request_, placed_, chosen, input_.limits(), control, timings);
        }));
    }

private:
    api::HalftoneRequest parsed(const OptionList& options) const {
        const auto list = text_options(options);
        return value_or_raise(api::parse_halftone(input_.with(list), "", input_.limits()));
    }

    Result<api::PlacedHalftone> placed(const Running& running) const {
        return run(running, [&](const Control& control, api::Timings& timings) {
            return api::place_halftone(request_, input_.limits(), input_.decode(), control, timings);
        });
    }

    PictureInput input_;
    api::HalftoneRequest request_;
    api::PlacedHalftone placed_;
};

/// Computes the pixels of a device from a picture. The option `device` must be given.
AnswerPointer answer_device(py::object picture, bool linear, const OptionList& options, const Running& running) {
    const PictureInput input(std::move(picture), linear);
    const auto list = text_options(options);
    const auto request = value_or_raise(api::parse_device(input.with(list), "", input.limits()));
    return keep(run(running, [&](const Control& control, api::Timings& timings) {
        return api::run_device(request, input.limits(), input.decode(), control, timings);
    }));
}

/// Returns the decoders for the pictures in a JSON body.
api::Decode embedded_decode(bool has_pictures) {
    return has_pictures ? file_decode() : api::Decode{};
}

/// Points that are placed, with the request that asked for them.
class Sample {
public:
    Sample(const std::string& body, bool has_pictures, const Running& running)
        : request_(parsed(body)), placed_(value_or_raise(placed(has_pictures, running))) {}

    AnswerPointer write(const std::string& format, const Running& running) const {
        const api::PointFormat& chosen = format.empty()
                                             ? *request_.output.format
                                             : request_.output.variant_of(format_of(api::sample_formats(), format));
        return keep(run(running, [&](const Control& control, api::Timings& timings) {
            return api::write_answer(request_, placed_, chosen, limits_, control, timings);
        }));
    }

private:
    api::SampleRequest parsed(const std::string& body) const {
        auto request = value_or_raise(api::parse_sample(body, {}, "", limits_));
        if (request.threshold_mask) raise({ErrorCode::Malformed, "format must not be a mask here", "format"});
        return request;
    }

    Result<api::PlacedSample> placed(bool has_pictures, const Running& running) const {
        const api::Decode decode = embedded_decode(has_pictures);
        return run(running, [&](const Control& control, api::Timings& timings) {
            return api::place_sample(request_, limits_, decode, control, timings);
        });
    }

    api::Limits limits_;
    api::SampleRequest request_;
    api::PlacedSample placed_;
};

/// Mesh of a request: the bytes of a file, or arrays.
class MeshInput {
public:
    /// @param mesh  bytes, or a tuple of arrays as in soup_of()
    explicit MeshInput(py::object mesh) : mesh_(std::move(mesh)) {
        if (py::isinstance<py::bytes>(mesh_)) return;
        const TriangleSoup soup = value_or_raise(soup_of(py::cast<py::tuple>(mesh_)));
        header_.max_vertices = soup.vertices.size();
        header_.max_triangles = soup.triangles.size();
        decode_.surface = [soup](std::string_view, const api::SurfaceHeader&, const std::stop_token&) {
            return Result<api::SurfaceContents>(api::SurfaceContents{soup});
        };
    }

    Result<api::SurfaceFile> file(const api::Limits& limits) const {
        if (decode_.surface) {
            if (header_.max_triangles > limits.max_faces) return api::too_many_faces(limits.max_faces);
            return api::SurfaceFile{{}, header_};
        }
        const std::string_view bytes = py::reinterpret_borrow<py::bytes>(mesh_);
        if (auto file = api::open_surface(bytes, {}, limits.max_faces, limits.max_pixels)) return *std::move(file);
        return failure(ErrorCode::Unsupported, "domain is not the file of a mesh", "domain");
    }

    const api::Decode& decode() const { return decode_.surface ? decode_ : file_decode(); }

private:
    py::object mesh_;  ///< owns the bytes to which requests refer
    api::SurfaceHeader header_;
    api::Decode decode_;  ///< returns the triangles of arrays; empty for a file
};

/// Points that are placed on a surface or in space, with their request.
/// @tparam Request  SurfaceRequest or VolumeRequest
template <class Request>
class Sample3 {
public:
    /// @param body  a mesh as for MeshInput; for points in space also, without the option `domain=solid`, JSON text or
    ///              the bytes of a file of voxels
    Sample3(py::object body, const OptionList& options, const Running& running)
        : body_(std::move(body)),
          request_(value_or_raise(parsed(text_options(options)))),
          placed_(value_or_raise(placed(running))) {}

    bool has_colours() const { return placed_.has_colours(); }
    bool has_texture() const { return placed_.has_texture(); }

    AnswerPointer write(const std::string& format, const Running& running) const {
        const auto& chosen = format.empty() ? *request_.format : format_of(Request::formats(), format);
        return keep(run(running, [&](const Control& control, api::Timings& timings) {
            return api::write_answer(request_, placed_, chosen, control, timings);
        }));
    }

private:
    using Placed = typename Request::Placed;

    Result<Request> parsed(const std::vector<api::TextOption>& options) {
        if constexpr (std::is_same_v<Request, api::SurfaceRequest>) {
            return api::parse_surface(mesh_.emplace(body_).file({}), options, "", {});
        } else {
            if (api::asks_for_solid(options)) return api::parse_solid(mesh_.emplace(body_).file({}), options, "", {});
            const auto text = py::cast<std::string_view>(body_);
            if (!py::isinstance<py::str>(body_)) return api::parse_volume(api::open_voxels(text, {}), options, "", {});
            return api::JsonDocument::parse(text).and_then(
                [](const api::JsonDocument& document) { return api::parse_volume(document.root(), {}, "", {}); });
        }
    }

    bool has_tiff() const {
        if constexpr (std::is_same_v<Request, api::VolumeRequest>) {
            return request_.density.is_tiff();
        }
        return false;
    }

    Result<Placed> placed(const Running& running) const {
        api::Decode decode = embedded_decode(has_tiff());
        if (mesh_) decode.surface = mesh_->decode().surface;
        return run(running, [&](const Control& control, api::Timings& timings) {
            return api::place_sample3(request_, decode, control, timings);
        });
    }

    py::object body_;  ///< owns the bytes to which the request refers
    std::optional<MeshInput> mesh_;
    Request request_;
    Placed placed_;
};

using SurfaceSample = Sample3<api::SurfaceRequest>;
using VolumeSample = Sample3<api::VolumeRequest>;

template <class Sample>
py::class_<Sample> bind_sample3(py::module_& module, const char* name) {
    return py::class_<Sample>(module, name)
        .def(py::init<py::object, const OptionList&, const Running&>(), py::arg("body"), py::arg("options"),
             py::arg("running"))
        .def("write", &Sample::write, py::arg("format"), py::arg("running"));
}

AnswerPointer run_parsed(Result<api::ParsedPointer> parsed, bool has_pictures, const Running& running) {
    const api::ParsedPointer request = value_or_raise(std::move(parsed));
    const api::Decode decode = embedded_decode(has_pictures);
    return keep(run(running, [&](const Control& control, api::Timings& timings) {
        return request->run(decode, control, timings, nullptr);
    }));
}

AnswerPointer answer_sample(const std::string& body, bool has_pictures, const Running& running) {
    return run_parsed(api::parse_sample_request(body, {}, "", {}), has_pictures, running);
}

AnswerPointer answer_analyze(const std::string& body, const Running& running) {
    return run_parsed(api::parse_analyze_request(body, {}, "", {}), false, running);
}

/// Analyses points on a mesh, which is as for MeshInput.
AnswerPointer answer_surface_analyze(py::object mesh, const OptionList& options, const Running& running) {
    const MeshInput input(std::move(mesh));
    const auto request = value_or_raise(api::parse_surface_analyze(input.file({}), text_options(options), "", {}));
    const api::Decode& decode = input.decode();
    return keep(run(running, [&](const Control& control, api::Timings& timings) {
        return api::run_surface_analyze(request, decode, control, timings);
    }));
}

using DoubleArray = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// Chooses among candidates, which are rows of a table of numbers.
AnswerPointer answer_choice(const DoubleArray& table, const OptionList& options, const Running& running) {
    std::string file =
        api::npy_header("<f8", static_cast<std::size_t>(table.shape(0)), static_cast<std::size_t>(table.shape(1)));
    file.append(reinterpret_cast<const char*>(table.data()), static_cast<std::size_t>(table.nbytes()));
    return run_parsed(api::parse_sample_request(file, text_options(options), "", {}), false, running);
}

void append_json(std::string& out, const double*& value, std::span<const py::ssize_t> shape) {
    if (shape.empty()) return api::append_shortest(out, *value++);
    out += '[';
    for (py::ssize_t i = 0; i < shape.front(); ++i) {
        if (i > 0) out += ',';
        append_json(out, value, shape.subspan(1));
    }
    out += ']';
}

/// Writes an array as nested JSON arrays. All values must be finite.
std::string json_of(const DoubleArray& array) {
    std::string out;
    const double* value = array.data();
    append_json(out, value, {array.shape(), static_cast<std::size_t>(array.ndim())});
    return out;
}

using Extensions = std::vector<std::pair<std::string, std::string>>;

/// Adds the name and the file extension of each format.
void append_extensions(const auto& formats, Extensions& list) {
    for (const auto* format : formats) list.emplace_back(format->file.name, format->file.extension);
}

/// Returns the name and the file extension of each format of any answer.
Extensions file_extensions() {
    Extensions list;
    append_extensions(api::halftone_formats(), list);
    append_extensions(api::device_formats(), list);
    append_extensions(api::sample_formats(), list);
    append_extensions(api::pixel_formats(), list);
    append_extensions(api::surface_formats(), list);
    append_extensions(api::volume_formats(), list);
    append_extensions(api::analyze_formats(), list);
    return list;
}

/// Writes a file. Raises OSError with its name, or the exception of the handler of a signal.
/// @param path  as bytes
void write_file(const std::string& path, const py::buffer& data) {
    const py::buffer_info bytes = data.request();
    const std::string_view text(static_cast<const char*>(bytes.ptr),
                                static_cast<std::size_t>(bytes.size * bytes.itemsize));
    bool is_raised = false;
    const auto failed = [&] {
        const py::gil_scoped_release released;
        return api::write_file(path, text, [&] {
            const py::gil_scoped_acquire acquired;
            return is_raised = PyErr_CheckSignals() != 0;
        });
    }();
    if (is_raised) throw py::error_already_set();
    if (!failed) return;
    errno = failed.value();
    const py::object name = py::module_::import("os").attr("fsdecode")(py::bytes(path));
    PyErr_SetFromErrnoWithFilenameObject(PyExc_OSError, name.ptr());
    throw py::error_already_set();
}

std::vector<std::string> option_names(const std::vector<std::string_view>& names) {
    return {names.begin(), names.end()};
}

}  // namespace
}  // namespace ccdt::python

/// The module ccdt._core: parses requests, computes and writes answers. The Python modules beside it are its only
/// callers. _core.pyi describes it.
PYBIND11_MODULE(_core, module) {
    namespace py = pybind11;
    using namespace ccdt;
    using namespace ccdt::python;

    module.doc() = "Parses requests, computes and writes answers.";
    module.attr("__version__") = CCDT_VERSION;

    py::class_<Running>(module, "Running")
        .def(py::init<std::size_t, py::object>(), py::arg("threads"), py::arg("progress"));

    py::class_<api::Answer>(module, "Answer", py::buffer_protocol())
        .def_buffer([](api::Answer& answer) {  // writable, because nothing else uses the bytes
            return py::buffer_info(reinterpret_cast<unsigned char*>(answer.body.data()),
                                   static_cast<py::ssize_t>(answer.body.size()));
        })
        .def_readonly("warnings", &api::Answer::warnings)
        .def_readonly("repaired", &api::Answer::repaired)
        .def_property_readonly("radius", [](const api::Answer& answer) -> std::optional<double> {
            return answer.dots ? std::optional(answer.dots->radius) : std::nullopt;
        });

    py::class_<Halftone>(module, "Halftone")
        .def(py::init<py::object, bool, const OptionList&, const Running&>(), py::arg("picture"), py::arg("linear"),
             py::arg("options"), py::arg("running"))
        .def("write", &Halftone::write, py::arg("format"), py::arg("running"));
    py::class_<Sample>(module, "Sample")
        .def(py::init<const std::string&, bool, const Running&>(), py::arg("body"), py::arg("has_pictures"),
             py::arg("running"))
        .def("write", &Sample::write, py::arg("format"), py::arg("running"));

    bind_sample3<VolumeSample>(module, "VolumeSample");
    bind_sample3<SurfaceSample>(module, "SurfaceSample")
        .def_property_readonly("has_colors", &SurfaceSample::has_colours)
        .def_property_readonly("has_texture", &SurfaceSample::has_texture);

    module.def("answer_device", &answer_device, py::arg("picture"), py::arg("linear"), py::arg("options"),
               py::arg("running"));
    module.def("answer_sample", &answer_sample, py::arg("body"), py::arg("has_pictures"), py::arg("running"));
    module.def("answer_analyze", &answer_analyze, py::arg("body"), py::arg("running"));
    module.def("answer_surface_analyze", &answer_surface_analyze, py::arg("mesh"), py::arg("options"),
               py::arg("running"));
    module.def("answer_choice", &answer_choice, py::arg("table"), py::arg("options"), py::arg("running"));
    module.def("json_of", &json_of, py::arg("array"));
    module.def(
        "png_pixels", [](const api::Answer& file) { return png_pixels(file.body); }, py::arg("file"));

    module.def("write_file", &write_file, py::arg("path"), py::arg("data"));
    module.def("file_extensions", &file_extensions);
    module.def("halftone_options", [] { return option_names(api::halftone_options()); });
    module.def("device_options", [] { return option_names(api::device_options()); });
    module.def("sample_options", [] { return option_names(api::sample_options()); });
    module.def("surface_options", [] { return option_names(api::surface_options()); });
    module.def("volume_options", [] { return option_names(api::volume_options()); });
    module.def("pixel_options", [] { return option_names(api::pixel_options()); });
    module.def("analyze_options", [] { return option_names(api::analyze_options()); });
}
