// SPDX-License-Identifier: GPL-3.0-or-later
#include "ccdt/service.h"

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <system_error>
#include <utility>

#include "api/analyze/analyze.h"
#include "api/decode/decode.h"
#include "api/halftone/device_picture.h"
#include "api/input/negotiation.h"
#include "api/map/object_option.h"
#include "api/map/shapefile_reader.h"
#include "api/operation/parsed_request.h"
#include "api/output/file_writer.h"
#include "api/output/formats.h"
#include "api/run/options.h"
#include "api/sample/pixels/pixel_formats.h"
#include "api/sample/spatial/surface_formats.h"
#include "api/sample/spatial/volume_formats.h"
#include "api/text/text.h"
#include "core/library/conversion.h"

namespace ccdt::v2 {
namespace {

using Options = std::vector<api::TextOption>;

/// Converts a zipped shapefile to GeoJSON. Removes the option `object`, which selects a shapefile of the archive.
std::string geojson_of(std::string_view archive, Options& options) {
    constexpr std::size_t kMaxBytes = std::size_t{64} << 20;  // as in the service
    const std::string object = value_of(api::take_object(options));
    std::string text;
    const auto take = [&](std::string_view piece) {
        if (piece.size() > kMaxBytes - text.size()) return false;
        text += piece;
        return true;
    };
    if (const auto read = api::read_shapefile(archive, {object, kMaxBytes}, take); !read) raise(read.error());
    return text;
}

/// Parses requests. Holds what parsed requests point to.
class Parser {
public:
    explicit Parser(const Request& request)
        : request_(request), body_(request.body), limits_{request.limits.max_sites, request.limits.max_pixels} {
        for (const Option& option : request.options) options_.push_back({option.name, option.value});
        if (request.operation != Operation::Sample || !body_.starts_with(api::kZipSignature)) return;
        text_ = geojson_of(body_, options_);
        body_ = text_;
    }

    api::ParsedPointer parse() const { return value_of(parse_operation()); }

private:
    ccdt::Result<api::ParsedPointer> parse_operation() const {
        switch (request_.operation) {
            case Operation::Halftone:
                return api::parse_halftone_request(body_,
                                                   is_json() ? api::HalftoneBody::Json : api::HalftoneBody::Picture,
                                                   options_, request_.accept, limits_);
            case Operation::Sample:
                return api::parse_sample_request(body_, options_, request_.accept, limits_);
            case Operation::Analyze:
                return api::parse_analyze_request(body_, options_, request_.accept, limits_);
        }
        raise(FailureCode::Malformed, "operation is not one of the enumerators", "operation");
    }

    /// Whether the body is JSON: no picture begins with `{`.
    bool is_json() const { return api::trim(body_, " \t\r\n").starts_with('{'); }

    const Request& request_;
    std::string_view body_;
    std::string text_;  ///< body converted from a shapefile
    Options options_;
    api::Limits limits_;
};

/// Returns the formats of the answers to requests of a kind.
std::vector<const api::FileFormat*> formats_of(Operation operation) {
    std::vector<const api::FileFormat*> files;
    const auto add = [&](const auto& rows) {
        const auto found = api::files_of(rows);
        files.insert(files.end(), found.begin(), found.end());
    };
    switch (operation) {
        case Operation::Halftone:
            add(api::halftone_formats());
            add(api::device_formats());
            break;
        case Operation::Sample:
            add(api::sample_formats());
            add(api::pixel_formats());
            add(api::surface_formats());
            add(api::volume_formats());
            break;
        case Operation::Analyze:
            add(api::analyze_formats());
            break;
    }
    return files;
}

/// Returns the media type of the format that the suffix of an output stands for.
std::string_view media_type_of(Operation operation, const std::filesystem::path& output) {
    const auto formats = formats_of(operation);
    const auto found = api::format_of_suffix(output.extension().string(), formats);
    if (found) return formats[*found]->media_type;
    raise(FailureCode::NotAcceptable,
          output.string() + ": " + found.error().message + ", or the option format must be given", "output");
}

[[noreturn]] void fail(const std::filesystem::path& file, const char* what, const std::error_code& error,
                       const char* field) {
    const std::string reason = error ? ": " + error.message() : "";
    raise(FailureCode::Unavailable, file.string() + " cannot be " + what + reason, field);
}

std::string read_file(const std::filesystem::path& file) {
    errno = 0;
    std::ifstream stream(file, std::ios::binary);
    std::string bytes;
    std::vector<char> piece(std::size_t{1} << 16);
    while (stream.read(piece.data(), static_cast<std::streamsize>(piece.size())) || stream.gcount() > 0)
        bytes.append(piece.data(), static_cast<std::size_t>(stream.gcount()));
    if (!stream.is_open() || stream.bad()) fail(file, "read", {errno, std::generic_category()}, "input");
    return bytes;
}

}  // namespace

Answer answer(const Request& request, const Control& control) {
    Execution execution(control);
    execution.check_stop();
    const Parser parser(request);
    const auto parsed = parser.parse();
    api::Timings timings;
    auto computed = value_of(parsed->run(api::decode_inline(), execution.control(), timings, nullptr));
    return {std::move(computed.media_type), std::move(computed.body), std::move(computed.warnings),
            std::move(computed.repaired), computed.partial};
}

Answer answer_file(Operation operation, const std::filesystem::path& input, const std::filesystem::path& output,
                   const std::vector<Option>& options, const Control& control) {
    const bool has_format = std::ranges::find(options, "format", &Option::name) != options.end();
    const std::string_view accept = has_format ? std::string_view() : media_type_of(operation, output);
    const std::string body = read_file(input);
    Answer result = answer({operation, body, options, accept}, control);
    const auto failed = api::write_file(output.string(), std::exchange(result.body, {}));
    if (failed) fail(output, "written", failed, "output");
    return result;
}

Answer halftone_file(const std::filesystem::path& picture, const std::filesystem::path& output,
                     const std::vector<Option>& options, const Control& control) {
    return answer_file(Operation::Halftone, picture, output, options, control);
}

Answer sample_file(const std::filesystem::path& domain, const std::filesystem::path& output,
                   const std::vector<Option>& options, const Control& control) {
    return answer_file(Operation::Sample, domain, output, options, control);
}

}  // namespace ccdt::v2
