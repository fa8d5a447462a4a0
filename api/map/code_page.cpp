// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/map/code_page.h"

#include <algorithm>
#include <array>
#include <cerrno>

#include <iconv.h>

#include "api/input/option_reader.h"
#include "api/text/text.h"

namespace ccdt::api {
namespace {

constexpr std::string_view kUtf8 = "UTF-8";

/// Names of the code pages for iconv().
constexpr auto kCodePages = std::to_array<const char*>(
    {"CP437",       "CP737",      "CP775",       "CP850",       "CP852",       "CP855",       "CP857",
     "CP858",       "CP860",      "CP861",       "CP862",       "CP863",       "CP864",       "CP865",
     "CP866",       "CP869",      "CP874",       "CP932",       "CP936",       "CP949",       "CP1250",
     "CP1251",      "CP1252",     "CP1253",      "CP1254",      "CP1255",      "CP1256",      "CP1257",
     "CP1258",      "ISO-8859-2", "ISO-8859-3",  "ISO-8859-4",  "ISO-8859-5",  "ISO-8859-6",  "ISO-8859-7",
     "ISO-8859-8",  "ISO-8859-9", "ISO-8859-10", "ISO-8859-11", "ISO-8859-13", "ISO-8859-14", "ISO-8859-15",
     "ISO-8859-16", "KOI8-R",     "KOI8-U",      "BIG5",        "BIG5-HKSCS",  "EUC-JP",      "EUC-KR",
     "GB18030",     "TIS-620",    "MACINTOSH"});

struct Alias {
    std::string_view name;  ///< in the form of plain()
    std::string_view page;
};

/// Other names of code pages.
constexpr auto kAliases = std::to_array<Alias>(
    {{"utf8", kUtf8},          {"65001", kUtf8},          {"88591", "CP1252"}, {"latin1", "CP1252"},
     {"latin2", "ISO-8859-2"}, {"latin9", "ISO-8859-15"}, {"sjis", "CP932"},   {"shiftjis", "CP932"},
     {"31j", "CP932"},         {"gbk", "CP936"},          {"gb2312", "CP936"}, {"euccn", "CP936"},
     {"uhc", "CP949"},         {"ksc56011987", "CP949"},  {"950", "BIG5"},     {"51949", "EUC-KR"},
     {"51932", "EUC-JP"},      {"54936", "GB18030"},      {"20866", "KOI8-R"}, {"21866", "KOI8-U"},
     {"10000", "MACINTOSH"},   {"macroman", "MACINTOSH"}});

struct Driver {
    int number;
    std::string_view page;
};

/// Code pages of the language drivers of dBASE and FoxPro.
constexpr auto kDrivers = std::to_array<Driver>(
    {{1, "437"},    {2, "850"},    {3, "1252"},   {4, "10000"}, {8, "865"},   {9, "437"},   {10, "850"},  {11, "437"},
     {13, "437"},   {14, "850"},   {15, "437"},   {16, "850"},  {17, "437"},  {18, "850"},  {19, "932"},  {20, "850"},
     {21, "437"},   {22, "850"},   {23, "865"},   {24, "437"},  {25, "437"},  {26, "850"},  {27, "437"},  {28, "863"},
     {29, "850"},   {31, "852"},   {34, "852"},   {35, "852"},  {36, "860"},  {37, "850"},  {38, "866"},  {55, "850"},
     {64, "852"},   {77, "936"},   {78, "949"},   {79, "950"},  {80, "874"},  {87, "1252"}, {88, "1252"}, {89, "1252"},
     {100, "852"},  {101, "866"},  {102, "865"},  {103, "861"}, {106, "737"}, {107, "857"}, {108, "863"}, {120, "950"},
     {121, "949"},  {122, "936"},  {123, "932"},  {124, "874"}, {134, "737"}, {135, "852"}, {136, "857"}, {200, "1250"},
     {201, "1251"}, {202, "1254"}, {203, "1253"}, {204, "1257"}});

/// Returns a name in small letters and digits, without prefixes that have no meaning.
std::string plain(std::string_view name) {
    constexpr auto kPrefixes =
        std::to_array<std::string_view>({"windows", "win", "ansi", "cp", "ibm", "oem", "dos", "ms", "iso"});
    std::string text = in_small_letters(name);
    std::erase_if(text, [](char c) { return (c < '0' || c > '9') && (c < 'a' || c > 'z'); });
    for (const std::string_view prefix : kPrefixes) {
        if (text.starts_with(prefix)) return text.substr(prefix.size());
    }
    return text;
}

/// Finds the name of a code page for iconv(); empty if it is unknown.
std::string_view find_name(std::string_view name) {
    constexpr std::string_view kDriver = "LDID/";
    if (name.starts_with(kDriver)) {
        const int number = parse_number<int>(name.substr(kDriver.size())).value_or(0);
        const auto* const driver = std::ranges::find(kDrivers, number, &Driver::number);
        return driver == kDrivers.end() ? std::string_view() : find_name(driver->page);
    }
    const std::string wanted = plain(name);
    const auto* const alias = std::ranges::find(kAliases, std::string_view(wanted), &Alias::name);
    if (alias != kAliases.end()) return alias->page;
    const auto* const page = std::ranges::find_if(kCodePages, [&](const char* each) { return plain(each) == wanted; });
    return page == kCodePages.end() ? std::string_view() : *page;
}

/// Opens the converter of a code page. Returns null if the C library does not have it.
void* open_converter(std::string_view page) {
    const iconv_t converter = iconv_open(kUtf8.data(), page.data());
    return converter == reinterpret_cast<iconv_t>(-1) ? nullptr : converter;
}

}  // namespace

CodePage::CodePage(void* converter)
    : converter_(converter, [](void* open) {
          if (open != nullptr) iconv_close(open);
      }) {}

Result<CodePage> CodePage::find(std::string_view name) {
    const std::string_view page = find_name(name);
    if (page == kUtf8) return CodePage(nullptr);
    void* const converter = page.empty() ? nullptr : open_converter(page);
    if (converter != nullptr) return CodePage(converter);
    if (name.empty())
        return failure(ErrorCode::Unusable,
                       "the .dbf file names no encoding: add a .cpg file with its name, such as UTF-8 or 1252");
    return failure(ErrorCode::Unusable, "the encoding of the .dbf file, " + excerpt(name) + ", is not supported");
}

std::string CodePage::to_utf8(std::string_view text) const {
    if (converter_ == nullptr || is_ascii(text)) return std::string(text);
    constexpr std::string_view kReplacement = "\xEF\xBF\xBD";
    std::string converted;
    std::string rest(text);
    iconv(converter_.get(), nullptr, nullptr, nullptr, nullptr);
    char* from = rest.data();
    std::size_t remaining = rest.size();
    while (remaining > 0) {
        std::array<char, 1024> piece{};
        char* to = piece.data();
        std::size_t space = piece.size();
        const bool is_done = iconv(converter_.get(), &from, &remaining, &to, &space) != static_cast<std::size_t>(-1);
        const bool is_wrong = !is_done && errno != E2BIG;
        converted.append(piece.data(), piece.size() - space);
        if (!is_wrong) continue;
        converted += kReplacement;
        ++from;
        --remaining;
    }
    return converted;
}

void load_code_pages() {
    // Converters that are never closed keep the tables loaded.
    static const auto kept = [] {
        std::array<void*, kCodePages.size()> converters{};
        std::ranges::transform(kCodePages, converters.begin(), open_converter);
        return converters;
    }();
    static_cast<void>(kept);
}

bool is_ascii(std::string_view text) {
    return std::ranges::all_of(text, [](char c) { return static_cast<unsigned char>(c) < 0x80; });
}

}  // namespace ccdt::api
