// SPDX-License-Identifier: GPL-3.0-or-later
#include "api/map/zip_archive.h"

#include <utility>

#include <zip.h>

#include "api/input/option_reader.h"
#include "api/text/file_kind.h"

namespace ccdt::api {
namespace {

tl::unexpected<Error> unusable(const std::string& name, std::string_view what) {
    return failure(ErrorCode::Unusable, "the file " + excerpt(name) + " in the archive" + ' ' + std::string(what));
}

tl::unexpected<Error> not_opened(zip_error_t& error) {
    const bool lacks_memory = zip_error_code_zip(&error) == ZIP_ER_MEMORY;
    zip_error_fini(&error);
    if (lacks_memory) return failure(ErrorCode::LimitExceeded, "the directory of the archive is too large");
    return failure(ErrorCode::Unusable, "the body is not a zip archive, or is truncated");
}

using OpenMember = std::unique_ptr<zip_file_t, decltype(&zip_fclose)>;

/// Reads `wanted` bytes, or fewer at the end of the file. Returns -1 for damaged data.
zip_int64_t read_up_to(zip_file_t* file, char* to, std::size_t wanted) {
    std::size_t done = 0;
    while (done < wanted) {
        const zip_int64_t size = zip_fread(file, to + done, wanted - done);
        if (size < 0) return -1;
        if (size == 0) break;
        done += static_cast<std::size_t>(size);
    }
    return static_cast<zip_int64_t>(done);
}

}  // namespace

ZipArchive::ZipArchive(struct zip* archive) : archive_(archive, zip_discard) {
    const auto count = static_cast<zip_uint64_t>(zip_get_num_entries(archive, 0));
    for (zip_uint64_t i = 0; i < count; ++i) {
        const char* const name = zip_get_name(archive, i, 0);
        names_.emplace_back(name == nullptr ? "" : name);
    }
}

Result<ZipArchive> ZipArchive::open(std::string_view bytes) {
    const std::string_view kind = kind_of_file(bytes);
    if (!kind.empty() && !bytes.starts_with("PK"))
        return failure(ErrorCode::Unusable, "the body is not a zip archive, but seems to be " + std::string(kind));
    zip_error_t error;
    zip_error_init(&error);
    zip_source_t* const source = zip_source_buffer_create(bytes.data(), bytes.size(), 0, &error);
    if (source == nullptr) return not_opened(error);
    zip_t* const archive = zip_open_from_source(source, ZIP_RDONLY, &error);
    if (archive == nullptr) {
        zip_source_free(source);
        return not_opened(error);
    }
    zip_error_fini(&error);
    if (const auto count = zip_get_num_entries(archive, 0); count > static_cast<zip_int64_t>(kMaxMembers)) {
        zip_discard(archive);
        return failure(ErrorCode::LimitExceeded, "the archive contains " + std::to_string(count) +
                                                     " files; the limit is " + std::to_string(kMaxMembers));
    }
    return ZipArchive(archive);
}

Result<std::string> ZipArchive::read(std::size_t member, std::size_t& budget) const {
    constexpr zip_uint64_t kNeeded = ZIP_STAT_SIZE | ZIP_STAT_COMP_METHOD | ZIP_STAT_ENCRYPTION_METHOD;
    const std::string& name = names_[member];
    zip_stat_t stat;
    if (zip_stat_index(archive_.get(), member, 0, &stat) != 0 || (stat.valid & kNeeded) != kNeeded)
        return unusable(name, "has no complete entry in the directory");
    if (stat.encryption_method != ZIP_EM_NONE) return unusable(name, "is encrypted");
    if (stat.comp_method != ZIP_CM_DEFLATE && stat.comp_method != ZIP_CM_STORE)
        return unusable(name, "is neither stored nor compressed by deflate");
    if (stat.size > budget) return failure(ErrorCode::LimitExceeded, {});
    const OpenMember file(zip_fopen_index(archive_.get(), member, 0), zip_fclose);
    if (file == nullptr) return unusable(name, "is damaged");
    std::string bytes(static_cast<std::size_t>(stat.size), '\0');
    const bool is_whole = read_up_to(file.get(), bytes.data(), bytes.size()) == static_cast<zip_int64_t>(bytes.size());
    // The library checks the CRC at the end of the data.
    char more = 0;
    if (!is_whole || read_up_to(file.get(), &more, 1) != 0)
        return unusable(name, "is damaged: its size or CRC differs from the one in the directory");
    budget -= bytes.size();
    return bytes;
}

}  // namespace ccdt::api
