#include "server/work/answer_name.h"

#include <set>
#include <string>

#include <gtest/gtest.h>

#include "server/work/form.h"

namespace ccdt::server {
namespace {

Question form_with(const std::string& boundary) {
    const std::string part = "--" + boundary + "\r\nContent-Disposition: form-data; name=\"";
    return {
        "/halftone", "", "multipart/form-data; boundary=" + boundary, "",
        part + "sites\"\r\n\r\n100\r\n" + part + "image\"; filename=\"a\"\r\n\r\npixels\r\n--" + boundary + "--\r\n"};
}

TEST(AnswerName, NamesWhatAnAnswerDependsOn) {
    const Question question{"/sample", "q", "application/json", "text/csv", "{}"};
    std::set<std::string> names{name_of_answer(question, {}, {})};
    EXPECT_EQ(*names.begin(), name_of_answer(question, {}, {}));
    for (auto part : {&Question::path, &Question::query, &Question::accept, &Question::body}) {
        Question other = question;
        other.*part += 'x';
        names.insert(name_of_answer(other, {}, {}));
    }
    Question other = question;
    other.content_type = "text/plain";
    names.insert(name_of_answer(other, {}, {}));
    other = question;
    std::swap(other.query, other.path);
    names.insert(name_of_answer(other, {}, {}));
    EXPECT_EQ(names.size(), 7U);
    for (const auto& name : names) {
        EXPECT_EQ(name.size(), 24U);
        EXPECT_EQ(name.find_first_of("=\", "), std::string::npos);
    }
}

TEST(AnswerName, DoesNotRunTextsTogether) {
    EXPECT_NE(name_of_answer({"/a", "bc", "", "", ""}, {}, {}), name_of_answer({"/ab", "c", "", "", ""}, {}, {}));
}

std::string name_of_form(const Question& question) {
    return name_of_answer(question, *find_fields(question), {});
}

TEST(AnswerName, LooksIntoForms) {
    const std::string name = name_of_form(form_with("one"));
    EXPECT_EQ(name, name_of_form(form_with("another-boundary")));
    Question other = form_with("one");
    other.body.replace(other.body.find("100"), 3, "101");
    EXPECT_NE(name, name_of_form(other));
}

TEST(AnswerName, NamesTheServersLimits) {
    const Question question{"/sample", "", "", "", "{}"};
    EXPECT_NE(name_of_answer(question, {}, {}), name_of_answer(question, {}, {.max_sites = 7}));
    EXPECT_NE(name_of_answer(question, {}, {}), name_of_answer(question, {}, {.max_pixels = 7}));
}

}  // namespace
}  // namespace ccdt::server
