// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/requests/answer_name.h"

#include <string>

#include "server/http/http.h"
#include "server/requests/digest.h"

namespace ccdt::server {
std::string name_of_answer(const ComputeRequest& request, const std::vector<FormPart>& fields,
                           const api::Limits& limits) {
    const std::string type = media_type(request.content_type);
    // Defaults of options depend on the limits.
    const std::string server = CCDT_VERSION " " + std::to_string(limits.max_sites) + ' ' +
                               std::to_string(limits.max_pixels) + ' ' + std::to_string(limits.max_faces);
    Digest digest;
    for (const std::string& text : {server, request.path, request.query, type, request.accept}) digest.add(text);
    for (const FormPart& field : fields) {
        digest.add(field.name);
        digest.add(field.content(request.body));
    }
    if (fields.empty()) digest.add(request.body);
    return digest.finish();
}

}  // namespace ccdt::server
