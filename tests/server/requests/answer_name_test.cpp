// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/requests/answer_name.h"

#include <set>
#include <string>

#include <gtest/gtest.h>

#include "server/requests/form.h"

namespace ccdt::server {
namespace {

ComputeRequest form_with(const std::string& boundary) {
    const std::string part = "--" + boundary + "\r\nContent-Disposition: form-data; name=\"";
    return {
        "/halftone", "", "multipart/form-data; boundary=" + boundary, "",
        part + "sites\"\r\n\r\n100\r\n" + part + "image\"; filename=\"a\"\r\n\r\npixels\r\n--" + boundary + "--\r\n"};
}

TEST(AnswerName, DependsOnEveryInputOfAnAnswer) {
    const ComputeRequest request{"/sample", "q", "application/json", "text/csv", "{}"};
    std::set<std::string> names{name_of_answer(request, {}, {})};
    EXPECT_EQ(*names.begin(), name_of_answer(request, {}, {}));
    for (auto part : {&ComputeRequest::path, &ComputeRequest::query, &ComputeRequest::accept, &ComputeRequest::body}) {
        ComputeRequest other = request;
        other.*part += 'x';
        names.insert(name_of_answer(other, {}, {}));
    }
    ComputeRequest other = request;
    other.content_type = "text/plain";
    names.insert(name_of_answer(other, {}, {}));
    other = request;
    std::swap(other.query, other.path);
    names.insert(name_of_answer(other, {}, {}));
    EXPECT_EQ(names.size(), 7U);
    for (const auto& name : names) {
        EXPECT_EQ(name.size(), 24U);
        EXPECT_EQ(name.find_first_of("=\", "), std::string::npos);
    }
}

TEST(AnswerName, SeparatesTexts) {
    EXPECT_NE(name_of_answer({"/a", "bc", "", "", ""}, {}, {}), name_of_answer({"/ab", "c", "", "", ""}, {}, {}));
}

std::string name_of_form(const ComputeRequest& request) {
    return name_of_answer(request, *find_fields(request), {});
}

TEST(AnswerName, IsIndependentOfTheBoundaryOfForms) {
    const std::string name = name_of_form(form_with("one"));
    EXPECT_EQ(name, name_of_form(form_with("another-boundary")));
    ComputeRequest other = form_with("one");
    other.body.replace(other.body.find("100"), 3, "101");
    EXPECT_NE(name, name_of_form(other));
}

TEST(AnswerName, DependsOnTheServersLimits) {
    const ComputeRequest request{"/sample", "", "", "", "{}"};
    EXPECT_NE(name_of_answer(request, {}, {}), name_of_answer(request, {}, {.max_sites = 7}));
    EXPECT_NE(name_of_answer(request, {}, {}), name_of_answer(request, {}, {.max_pixels = 7}));
    EXPECT_NE(name_of_answer(request, {}, {}), name_of_answer(request, {}, {.max_faces = 7}));
}

}  // namespace
}  // namespace ccdt::server
