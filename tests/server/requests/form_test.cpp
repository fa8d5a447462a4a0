// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/requests/form.h"

#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "server/http/http.h"

namespace ccdt::server {
namespace {

using Fields = std::vector<std::pair<std::string, std::string>>;

ComputeRequest form_of(const Fields& fields, const std::string& query = "") {
    ComputeRequest request{"/halftone", query, "Multipart/Form-Data; boundary=b", "image/png", {}};
    for (const auto& [name, content] : fields)
        request.body += "--b\r\nContent-Disposition: form-data; name=\"" + name + "\"\r\n\r\n" + content + "\r\n";
    request.body += "--b--\r\n";
    return request;
}

Result<ComputeRequest> taken_apart(ComputeRequest request, std::string_view part = "image") {
    const auto fields = find_fields(request);
    if (!fields) return tl::unexpected(fields.error());
    if (auto apart = take_apart(request, *fields, part); !apart) return tl::unexpected(apart.error());
    return request;
}

TEST(Form, IsSplitIntoAPictureAndAQuery) {
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

TEST(Form, NamesTheFormatsOfMeshes) {
    ComputeRequest request{"/sample", "", "multipart/form-data; boundary=b", "", {}};
    request.body =
        "--b\r\nContent-Disposition: form-data; name=\"mesh\"; filename=\"a.fbx\"\r\n\r\nKaydara\r\n--b--\r\n";
    const auto fields = find_fields(request);
    ASSERT_FALSE(fields);
    EXPECT_EQ(fields.error().message, "the file is not a mesh of a known format: STL, OBJ, PLY, OFF, glTF or GLB");
    request.body.replace(request.body.find("Kaydara"), 7, "v 0 0 0\n");
    EXPECT_TRUE(find_fields(request));
}

TEST(Form, NamesTheFormatsOfVoxels) {
    ComputeRequest request{"/sample", "", "multipart/form-data; boundary=b", "", {}};
    request.body =
        "--b\r\nContent-Disposition: form-data; name=\"density\"; filename=\"a.raw\"\r\n\r\n123\r\n--b--\r\n";
    const auto refused = taken_apart(request, "map");
    ASSERT_FALSE(refused);
    EXPECT_EQ(refused.error().message, "the file does not have voxels in a known format: NPY or TIFF");
    EXPECT_EQ(refused.error().field, "density");
    request.body.replace(request.body.find("123"), 3, "\x93NUMPY");
    EXPECT_EQ(taken_apart(request, "map")->body, "\x93NUMPY");
}

TEST(Form, AppendsFieldsWithAnyContentToTheQuery) {
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

TEST(Form, RequiresExactlyOnePicture) {
    for (const Fields& fields : {Fields{}, Fields{{"sites", "1"}}, Fields{{"image", "x"}, {"file", "y"}}}) {
        const auto apart = taken_apart(form_of(fields));
        ASSERT_FALSE(apart);
        EXPECT_EQ(apart.error().code, ErrorCode::Malformed);
        EXPECT_EQ(apart.error().field, fields.size() < 2 ? "image" : "file");
        const bool is_missing = apart.error().message.find("has no part `image` or `file`") != std::string::npos;
        EXPECT_EQ(is_missing, fields.size() < 2);
    }
}

TEST(Form, TakesAMapAsTheBody) {
    EXPECT_EQ(taken_apart(form_of({{"map", "x"}, {"image", "y"}}), "map")->body, "x");
    EXPECT_EQ(taken_apart(form_of({{"map", "x"}, {"image", "y"}}), "map")->query, "image=y");
    EXPECT_EQ(taken_apart(form_of({{"file", "x"}}), "map")->body, "x");
    EXPECT_EQ(taken_apart(form_of({{"image", "x"}}), "map").error().field, "map");
}

TEST(Form, KeepsOtherBodies) {
    const ComputeRequest picture{"/halftone", "a=b", "image/png", "", "--b"};
    const auto apart = taken_apart(picture);
    ASSERT_TRUE(apart);
    EXPECT_EQ(apart->body, picture.body);
    EXPECT_EQ(apart->query, picture.query);
    EXPECT_EQ(apart->content_type, picture.content_type);
}

TEST(Form, ReportsMalformedForms) {
    ComputeRequest request = form_of({{"image", "x"}});
    request.body.resize(20);
    EXPECT_EQ(taken_apart(request).error().code, ErrorCode::Malformed);
}

}  // namespace
}  // namespace ccdt::server
