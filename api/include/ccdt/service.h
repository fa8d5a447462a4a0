// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

/// @file
/// The library libccdt-api: all that the service offers, without HTTP. Options, their ranges and the bytes of answers
/// are those of the service. api/README.md describes them.
///
///     ccdt::halftone_file("photo.jpg", "dots.png", {{"sites", "20000"}, {"color", "cmyk"}});
///
/// Unlike the service, the library decodes pictures, maps and meshes in the calling process, without a sandbox. Do not
/// use it for untrusted files. If the program itself uses OpenImageIO, note that decoding sets the attributes `threads`
/// to 1 and `try_all_readers` to 0 for the whole process. ccdt/ccdt.h describes the compatibility of versions and the
/// use of threads.

#include <cstddef>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "ccdt/abi.h"
#include "ccdt/control.h"
#include "ccdt/exception.h"

namespace ccdt::v2 {

/// Kinds of requests.
enum class Operation {
    Halftone,  ///< a picture becomes dots, or the pixels of a device: POST /halftone
    Sample,    ///< a domain becomes points, a mask or pixels: POST /sample
    Analyze,   ///< measures of how evenly points are spread: POST /analyze
};

/// An option, as in the query of a URL.
struct Option {
    std::string name;
    std::string value;
};

/// Limits on requests. A message that calls a limit max-sites or max-pixels means these. The limit max-faces is always
/// 4,000,000 triangles.
struct Limits {
    std::size_t max_sites = 2'000'000;    ///< maximum number of points
    std::size_t max_pixels = 64'000'000;  ///< maximum number of pixels of a picture and of an answer
};

/// A request to the service.
struct Request {
    Operation operation = Operation::Halftone;
    /// Bytes as they are sent to the service: a picture, JSON, GeoJSON, TopoJSON, a zipped shapefile, a mesh or voxels.
    /// The content determines the format. All of these but JSON take their options from `options`, and a JSON request
    /// has them as members. A JSON request for a halftone takes both. Analyze takes points on a mesh as the option
    /// `points`, which is the content of a file.
    std::string_view body;
    std::vector<Option> options = {};
    std::string_view accept = {};  ///< wanted media types, as in an Accept header; the option `format` takes precedence
    Limits limits = {};
};

/// The answer to a request.
struct Answer {
    std::string media_type;  ///< such as image/png
    std::string body;
    std::string warnings;  ///< JSON array of objects with `pointer`, `detail` and, for meshes, `face`; empty if there
                           ///< are none or if the body contains them
    std::string repairs;   ///< repairs of polygons or meshes, as `warnings`
    bool partial = false;  ///< whether a stop ended the computation early; only with the option on_deadline=partial
};

/// Answers a request.
///
/// Errors: those of the service. The field is the name of an option, or a JSON Pointer into the body. If several
/// options are invalid, the message names all of them, and code and field are those of the first. The same request gets
/// the same bytes, except for `elapsed_ms` in JSON, whatever the number of threads.
CCDT_EXPORT Answer answer(const Request& request, const Control& control = {});

/// Answers a request whose body is a file, and writes the body of the answer to another file.
///
/// @param operation  kind of the request
/// @param input      file with a picture or JSON for Halftone; a map, a mesh, voxels or JSON for Sample; a mesh or
///                   JSON for Analyze
/// @param output     file to be written or replaced. Its suffix selects the format, unless the option or the member
///                   `format` is given. The file appears when it is complete; after an error it is unchanged.
/// @returns          the answer, whose body has been moved to the file
///
/// Errors: those of answer(); NotAcceptable if no format has the suffix and there is no option `format`; Unavailable
/// for a file that cannot be read or written, with the field `input` or `output`.
CCDT_EXPORT Answer answer_file(Operation operation, const std::filesystem::path& input,
                               const std::filesystem::path& output, const std::vector<Option>& options = {},
                               const Control& control = {});

/// Turns the file of a picture into a halftone, as answer_file() does.
CCDT_EXPORT Answer halftone_file(const std::filesystem::path& picture, const std::filesystem::path& output,
                                 const std::vector<Option>& options = {}, const Control& control = {});

/// Distributes points in the polygons or on the mesh of a file, as answer_file() does.
CCDT_EXPORT Answer sample_file(const std::filesystem::path& domain, const std::filesystem::path& output,
                               const std::vector<Option>& options = {}, const Control& control = {});

}  // namespace ccdt::v2
