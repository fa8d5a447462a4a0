// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <sqlite3.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>

namespace ccdt::server {

/// An error that SQLite returned.
class SqliteError : public std::runtime_error {
public:
    SqliteError(int code, const std::string& message) : std::runtime_error(message), code_(code) {}

    int code() const { return code_; }  ///< SQLITE_FULL and so on

private:
    int code_;
};

/// A connection to a database, for one thread at a time. All failures throw SqliteError.
class Database {
public:
    explicit Database(const std::string& path);

    void execute(const char* statements);

    /// Executes a statement that returns one integer.
    std::int64_t value_of(const char* statement);

    /// Reserves disk space for the first `bytes` of the file, so that writing to them cannot fail for lack of space.
    /// Does nothing for a database in memory. Throws SQLITE_FULL if there is no space.
    void allocate(std::size_t bytes);

    /// Reserves disk space for the write-ahead log. The log must exist; SQLite creates it when the database is first
    /// read.
    void allocate_log(std::size_t bytes);

    std::int64_t last_row() const { return sqlite3_last_insert_rowid(handle_.get()); }
    std::int64_t changes() const { return sqlite3_changes64(handle_.get()); }

    /// Overwrites the blob column `body` of a row without an intermediate copy. The blob must have the size of `body`.
    void write_body(const char* table, std::int64_t row, std::string_view body);

    /// Reads the blob column `body` of a row.
    /// @param max_bytes  size limit in bytes; a larger blob is an error (SQLITE_CORRUPT)
    std::string read_body(const char* table, std::int64_t row, std::size_t max_bytes);

private:
    friend class Statement;
    struct Close {
        void operator()(sqlite3* handle) const { sqlite3_close_v2(handle); }
    };
    struct CloseBlob {
        void operator()(sqlite3_blob* blob) const { sqlite3_blob_close(blob); }
    };
    using Blob = std::unique_ptr<sqlite3_blob, CloseBlob>;

    void check(int code) const;
    void allocate(int which, std::size_t bytes);
    Blob open_body(const char* table, std::int64_t row, bool to_write);

    std::unique_ptr<sqlite3, Close> handle_;
};

/// A prepared statement that steps through its rows.
class Statement {
public:
    /// Binds the values to the parameters (`?`) of the statement, in sequence. Texts must outlive the statement.
    template <class... Values>
    Statement(Database& database, const char* sql, const Values&... values) : database_(database) {
        prepare(sql);
        int position = 0;
        (bind(++position, values), ...);
    }

    /// Steps to the next row.
    /// @returns  false if there is no further row
    bool step();

    /// Steps through all rows.
    void run() {
        while (step()) {
        }
    }

    std::int64_t integer(int column) const { return sqlite3_column_int64(handle_.get(), column); }
    double real(int column) const { return sqlite3_column_double(handle_.get(), column); }
    std::string text(int column) const;

    /// Returns a value and its type as text. Different values have different texts.
    std::string image(int column) const;

    bool is_null(int column) const { return sqlite3_column_type(handle_.get(), column) == SQLITE_NULL; }

private:
    struct Finalize {
        void operator()(sqlite3_stmt* handle) const { sqlite3_finalize(handle); }
    };

    void prepare(const char* sql);
    void bind(int position, std::int64_t value);
    void bind(int position, double value);
    void bind(int position, std::string_view value);
    template <class T>
    void bind(int position, const std::optional<T>& value) {
        if (value) bind(position, *value);  // unbound parameters are null
    }

    Database& database_;
    std::unique_ptr<sqlite3_stmt, Finalize> handle_;
};

/// A transaction that is rolled back by the destructor unless it was committed.
class Transaction {
public:
    explicit Transaction(Database& database) : database_(database) { database_.execute("BEGIN IMMEDIATE"); }
    ~Transaction();

    Transaction(const Transaction&) = delete;
    Transaction& operator=(const Transaction&) = delete;

    void commit();

private:
    Database& database_;
    bool open_ = true;
};

}  // namespace ccdt::server
