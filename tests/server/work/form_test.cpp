#include "server/work/form.h"

#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "server/http/http.h"

namespace ccdt::server {
namespace {

using Fields = std::vector<std::pair<std::string, std::string>>;

Question form_of(const Fields& fields, const std::string& query = "") {
    Question question{"/halftone", query, "Multipart/Form-Data; boundary=b", "image/png", {}};
    for (const auto& [name, content] : fields)
        question.body += "--b\r\nContent-Disposition: form-data; name=\"" + name + "\"\r\n\r\n" + content + "\r\n";
    question.body += "--b--\r\n";
    return question;
}

Result<Question> taken_apart(Question question) {
    const auto fields = find_fields(question);
    if (!fields) return tl::unexpected(fields.error());
    if (auto apart = take_apart(question, *fields); !apart) return tl::unexpected(apart.error());
    return question;
}

TEST(Form, BecomesAPictureAndAQuery) {
    const std::string picture("\0\r\n--\xff", 6);
    const auto apart = taken_apart(form_of({{"sites", "100"}, {"image", picture}, {"format", "svg"}}));
    ASSERT_TRUE(apart);
    EXPECT_EQ(apart->body, picture);
    EXPECT_EQ(apart->query, "sites=100&format=svg");
    EXPECT_EQ(apart->content_type, "");
    EXPECT_EQ(apart->path, "/halftone");
    EXPECT_EQ(apart->accept, "image/png");
    EXPECT_EQ(taken_apart(form_of({{"file", picture}}))->body, picture);
}

TEST(Form, AddsItsFieldsToTheQueryWhateverTheyHold) {
    const Fields fields = {{"a&b=c", "%+ &=#?"}, {"empty", ""}, {"a", "\xff\xc3\xa4"}, {"a", "again"}};
    Fields with_picture = fields;
    with_picture.emplace_back("image", "x");
    for (const std::string query : {"", "seed=4", "seed=4&", "seed"}) {
        const auto options = parse_query(taken_apart(form_of(with_picture, query))->query);
        const auto before = parse_query(query).size();
        ASSERT_EQ(options.size(), before + fields.size()) << query;
        for (std::size_t i = 0; i < fields.size(); ++i) {
            EXPECT_EQ(options[before + i].name, fields[i].first);
            EXPECT_EQ(options[before + i].value, fields[i].second);
        }
    }
}

TEST(Form, HoldsOnePicture) {
    for (const Fields& fields : {Fields{}, Fields{{"sites", "1"}}, Fields{{"image", "x"}, {"file", "y"}}}) {
        const auto apart = taken_apart(form_of(fields));
        ASSERT_FALSE(apart);
        EXPECT_EQ(apart.error().code, ErrorCode::Malformed);
        EXPECT_EQ(apart.error().field, "image");
    }
}

TEST(Form, LeavesOtherBodiesAlone) {
    const Question picture{"/halftone", "a=b", "image/png", "", "--b"};
    const auto apart = taken_apart(picture);
    ASSERT_TRUE(apart);
    EXPECT_EQ(apart->body, picture.body);
    EXPECT_EQ(apart->query, picture.query);
    EXPECT_EQ(apart->content_type, picture.content_type);
}

TEST(Form, TellsWhatIsWrongWithIt) {
    Question question = form_of({{"image", "x"}});
    question.body.resize(20);
    EXPECT_EQ(taken_apart(question).error().code, ErrorCode::Malformed);
}

}  // namespace
}  // namespace ccdt::server
