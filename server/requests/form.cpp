// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/requests/form.h"

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>

#include "api/sample/spatial/voxel_input.h"
#include "api/surface/surface_header.h"
#include "server/http/http.h"

namespace ccdt::server {
namespace {

constexpr std::string_view kFile = "file";  ///< name of the field that is the body at every endpoint
constexpr std::string_view kMap = "map";
/// Name of a field with voxels. If it is a file, it is the body of a form that has no field kMap or kFile.
constexpr std::string_view kDensity = "density";

bool is_form(const ComputeRequest& request) {
    return media_type(request.content_type) == "multipart/form-data";
}

bool is_body(const FormPart& field, std::string_view part) {
    return field.name == part || field.name == kFile;
}

Result<const FormPart*> find_body(const std::vector<FormPart>& fields, std::string_view part) {
    const FormPart* body = nullptr;
    const std::string name(part), names = part == kMap ? "`map`, `file` or `mesh`" : '`' + name + "` or `file`";
    for (const FormPart& field : fields) {
        if (!is_body(field, part)) continue;
        if (body != nullptr)
            return failure(ErrorCode::Malformed, "the form has more than one of the parts " + names, field.name);
        body = &field;
    }
    if (body != nullptr) return body;
    const auto is_density = [](const FormPart& field) { return field.name == kDensity && field.is_file; };
    const auto density = std::ranges::find_if(fields, is_density);
    if (part != kMap) return failure(ErrorCode::Malformed, "the form has no part " + names + " with the " + name, name);
    if (density == fields.end())
        return failure(ErrorCode::Malformed,
                       "the form has no part " + names + ", and no part `density` with a file name", name);
    return &*density;
}

}  // namespace

Result<std::vector<FormPart>> find_fields(const ComputeRequest& request) {
    if (!is_form(request)) return {};
    auto fields = parse_multipart(request.body, request.content_type);
    if (!fields) return failure(ErrorCode::Malformed, std::move(fields.error().error.message));
    for (FormPart& field : *fields) {
        if (field.name != "mesh" || !field.is_file) continue;
        if (!api::recognise_surface(field.content(request.body)))
            return failure(ErrorCode::Unsupported,
                           "the file is not a mesh of a known format: STL, OBJ, PLY, OFF, glTF or GLB", field.name);
        field.name = kFile;
    }
    return *std::move(fields);
}

Result<void> take_apart(ComputeRequest& request, const std::vector<FormPart>& fields, std::string_view part) {
    if (!is_form(request)) return {};
    const auto body = find_body(fields, part);
    if (!body) return tl::unexpected(body.error());
    if ((*body)->name == kDensity && !api::is_voxel_file((*body)->content(request.body)))
        return failure(ErrorCode::Unsupported, "the file does not have voxels in a known format: NPY or TIFF",
                       std::string(kDensity));
    for (const FormPart& field : fields) {
        if (&field == *body) continue;
        if (!request.query.empty()) request.query += '&';
        request.query += encode_percent(field.name) + '=' + encode_percent(field.content(request.body));
    }
    request.body.resize((*body)->begin + (*body)->size);
    request.body.erase(0, (*body)->begin);
    request.content_type.clear();
    return {};
}

}  // namespace ccdt::server
