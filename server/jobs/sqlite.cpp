// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/sqlite.h"

#include <bit>
#include <cerrno>

namespace ccdt::server {

Database::Database(const std::string& path) {
    sqlite3* handle = nullptr;
    // Callers serialize access, so SQLite needs no mutex.
    const int flags = SQLITE_OPEN_READWRITE | SQLITE_OPEN_CREATE | SQLITE_OPEN_NOMUTEX;
    const int code = sqlite3_open_v2(path.c_str(), &handle, flags, nullptr);
    handle_.reset(handle);  // a handle must be closed even after an error
    check(code);
    sqlite3_extended_result_codes(handle, 0);
}

/// Throws if a call failed. Reports an exceeded quota or file size limit as SQLITE_FULL, like a full disk.
void Database::check(int code) const {
    if (code == SQLITE_OK) return;
    int reported = code & 0xff;
    const int reason = handle_ && reported == SQLITE_IOERR ? sqlite3_system_errno(handle_.get()) : 0;
    if (reason == EDQUOT || reason == EFBIG) reported = SQLITE_FULL;
    throw SqliteError(reported, handle_ ? sqlite3_errmsg(handle_.get()) : sqlite3_errstr(code));
}

/// Allocates disk space for the first `bytes` of a file, in chunks of 1 MiB to save system calls.
/// @param which  SQLite's opcode that selects the file
void Database::allocate(int which, std::size_t bytes) {
    sqlite3_file* file = nullptr;
    check(sqlite3_file_control(handle_.get(), "main", which, static_cast<void*>(&file)));
    if (file == nullptr || file->pMethods == nullptr) return;  // in memory
    int chunk = 1 << 20;
    auto size = static_cast<sqlite3_int64>(bytes);
    file->pMethods->xFileControl(file, SQLITE_FCNTL_CHUNK_SIZE, &chunk);
    if (file->pMethods->xFileControl(file, SQLITE_FCNTL_SIZE_HINT, &size) != SQLITE_OK)
        throw SqliteError(SQLITE_FULL, "the disk is full");
}

void Database::allocate(std::size_t bytes) {
    allocate(SQLITE_FCNTL_FILE_POINTER, bytes);
}

void Database::allocate_log(std::size_t bytes) {
    allocate(SQLITE_FCNTL_JOURNAL_POINTER, bytes);
}

void Database::execute(const char* statements) {
    check(sqlite3_exec(handle_.get(), statements, nullptr, nullptr, nullptr));
}

std::int64_t Database::value_of(const char* statement) {
    Statement query(*this, statement);
    return query.step() ? query.integer(0) : 0;
}

Database::Blob Database::open_body(const char* table, std::int64_t row, bool to_write) {
    sqlite3_blob* blob = nullptr;
    const int code = sqlite3_blob_open(handle_.get(), "main", table, "body", row, to_write ? 1 : 0, &blob);
    Blob opened(blob);
    check(code);
    return opened;
}

void Database::write_body(const char* table, std::int64_t row, std::string_view body) {
    const Blob blob = open_body(table, row, true);
    check(sqlite3_blob_write(blob.get(), body.data(), static_cast<int>(body.size()), 0));
}

std::string Database::read_body(const char* table, std::int64_t row, std::size_t max_bytes) {
    const Blob blob = open_body(table, row, false);
    const auto size = static_cast<std::size_t>(sqlite3_blob_bytes(blob.get()));
    if (size > max_bytes) throw SqliteError(SQLITE_CORRUPT, "a body is longer than when it was written");
    std::string body(size, '\0');
    check(sqlite3_blob_read(blob.get(), body.data(), static_cast<int>(body.size()), 0));
    return body;
}

void Statement::prepare(const char* sql) {
    sqlite3_stmt* handle = nullptr;
    const int code = sqlite3_prepare_v2(database_.handle_.get(), sql, -1, &handle, nullptr);
    handle_.reset(handle);
    database_.check(code);
}

bool Statement::step() {
    const int code = sqlite3_step(handle_.get());
    if (code == SQLITE_ROW) return true;
    if (code != SQLITE_DONE) database_.check(code);
    return false;
}

std::string Statement::text(int column) const {
    const auto* text = reinterpret_cast<const char*>(sqlite3_column_text(handle_.get(), column));
    return text == nullptr ? ""
                           : std::string(text, static_cast<std::size_t>(sqlite3_column_bytes(handle_.get(), column)));
}

std::string Statement::image(int column) const {
    const int type = sqlite3_column_type(handle_.get(), column);
    std::string image = std::to_string(type) + ' ';
    if (type == SQLITE_FLOAT) return image + std::to_string(std::bit_cast<std::uint64_t>(real(column)));
    return image + text(column);
}

void Statement::bind(int position, std::int64_t value) {
    database_.check(sqlite3_bind_int64(handle_.get(), position, value));
}

void Statement::bind(int position, double value) {
    database_.check(sqlite3_bind_double(handle_.get(), position, value));
}

void Statement::bind(int position, std::string_view value) {
    // A null pointer would be bound as NULL.
    const char* const begin = value.data() == nullptr ? "" : value.data();
    database_.check(sqlite3_bind_text64(handle_.get(), position, begin, value.size(), SQLITE_STATIC, SQLITE_UTF8));
}

Transaction::~Transaction() {
    if (!open_) return;
    try {
        database_.execute("ROLLBACK");
    } catch (const SqliteError&) {
        // The statement that failed may have caused a rollback already.
    }
}

void Transaction::commit() {
    database_.execute("COMMIT");
    open_ = false;
}

}  // namespace ccdt::server
