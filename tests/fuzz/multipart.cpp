#include "server/http/multipart.h"

#include "tests/fuzz/checks.h"

namespace ccdt::fuzz {
namespace {

/// Parts follow each other, each between two boundaries and without one of its own.
void check_parts(const std::vector<server::FormPart>& parts, std::string_view body, std::string_view content_type) {
    const auto boundary = server::header_parameter(content_type, "boundary");
    CCDT_CHECK(boundary.size() <= 70 && boundary.find_first_of("\r\n\"") == std::string::npos);
    CCDT_CHECK(parts.size() <= 1000);
    const std::string delimiter = "\r\n--" + boundary;
    std::size_t end = 0;
    for (const auto& part : parts) {
        CCDT_CHECK(!part.name.empty());
        CCDT_CHECK(part.begin >= end + 4 && part.begin <= body.size() && part.size <= body.size() - part.begin);
        CCDT_CHECK(body.substr(part.begin - 4, 4) == "\r\n\r\n");
        end = part.begin + part.size;
        CCDT_CHECK(body.substr(end).starts_with(delimiter));
        CCDT_CHECK(part.content(body).find(delimiter) == std::string_view::npos);
    }
}

/// What stands after the last boundary changes nothing.
void check_epilogue(const std::vector<server::FormPart>& parts, std::string_view body, std::string_view content_type) {
    const auto again = server::parse_multipart(std::string(body) + "\r\nepilogue", content_type);
    CCDT_CHECK(again && again->size() == parts.size());
    for (std::size_t i = 0; i < parts.size(); ++i) {
        const auto& a = parts[i];
        const auto& b = (*again)[i];
        CCDT_CHECK(a.name == b.name && a.begin == b.begin && a.size == b.size);
    }
}

}  // namespace
}  // namespace ccdt::fuzz

/// A line with the Content-Type of a form, and its body.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace ccdt;
    auto body = fuzz::text_of(data, size);
    const auto content_type = fuzz::take_line(body);
    const auto parts = server::parse_multipart(body, content_type);
    if (parts) {
        fuzz::check_parts(*parts, body, content_type);
        fuzz::check_epilogue(*parts, body, content_type);
    } else {
        fuzz::check_problem(parts.error());
        CCDT_CHECK(parts.error().status == 400);
    }
    return 0;
}
