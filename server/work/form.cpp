#include "server/work/form.h"

#include <string_view>
#include <utility>

#include "server/http/http.h"

namespace ccdt::server {
namespace {

bool is_form(const ComputeRequest& request) {
    return media_type(request.content_type) == "multipart/form-data";
}

bool is_picture(const FormPart& field) {
    return field.name == "image" || field.name == "file";
}

Result<const FormPart*> find_picture(const std::vector<FormPart>& fields) {
    const FormPart* picture = nullptr;
    for (const FormPart& field : fields) {
        if (!is_picture(field)) continue;
        if (picture != nullptr)
            return failure(ErrorCode::Malformed, "the form contains more than one picture", "image");
        picture = &field;
    }
    if (picture == nullptr)
        return failure(ErrorCode::Malformed, "the form has no part `image` or `file` with the picture", "image");
    return picture;
}

}  // namespace

Result<std::vector<FormPart>> find_fields(const ComputeRequest& request) {
    if (!is_form(request)) return {};
    return parse_multipart(request.body, request.content_type).map_error([](Problem problem) {
        return Error{ErrorCode::Malformed, std::move(problem.error.message), {}};
    });
}

Result<void> take_apart(ComputeRequest& request, const std::vector<FormPart>& fields) {
    if (!is_form(request)) return {};
    const auto picture = find_picture(fields);
    if (!picture) return tl::unexpected(picture.error());
    for (const FormPart& field : fields) {
        if (is_picture(field)) continue;
        if (!request.query.empty()) request.query += '&';
        request.query += encode_percent(field.name) + '=' + encode_percent(field.content(request.body));
    }
    request.body.resize((*picture)->begin + (*picture)->size);
    request.body.erase(0, (*picture)->begin);
    request.content_type.clear();
    return {};
}

}  // namespace ccdt::server
