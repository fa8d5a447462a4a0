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

/// A database of which one connection is used, by one thread at a time. All that fails throws SqliteError.
class Database {
public:
    explicit Database(const std::string& path);

    void execute(const char* statements);

    /// Executes a statement that yields one value.
    std::int64_t value_of(const char* statement);

    /// Takes room on the disk for the first bytes of the file, which may then be written whatever others take. Nothing
    /// for a database in memory. No room: SQLITE_FULL.
    void allocate(std::size_t bytes);

    /// Takes room for the log, which has to be there: the database has been read.
    void allocate_log(std::size_t bytes);

    std::int64_t last_row() const { return sqlite3_last_insert_rowid(handle_.get()); }
    std::int64_t changes() const { return sqlite3_changes64(handle_.get()); }

    /// Fills the blob `body` of a row, which has that size, without a copy of it in between.
    void write_body(const char* table, std::int64_t row, std::string_view body);

    /// @param most  bytes; more are not believed (SQLITE_CORRUPT)
    std::string read_body(const char* table, std::int64_t row, std::size_t most);

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

/// A statement on its way through its rows.
class Statement {
public:
    /// Binds the values to its request marks, in order. Texts must stay until its end.
    template <class... Values>
    Statement(Database& database, const char* sql, const Values&... values) : database_(database) {
        prepare(sql);
        int place = 0;
        (bind(++place, values), ...);
    }

    /// Goes to the next row.
    /// @returns  false if there is none
    bool step();

    /// Goes to the end.
    void run() {
        while (step()) {
        }
    }

    std::int64_t integer(int column) const { return sqlite3_column_int64(handle_.get(), column); }
    double real(int column) const { return sqlite3_column_double(handle_.get(), column); }
    std::string text(int column) const;

    /// A value with its type, so that different values have different ones.
    std::string image(int column) const;

    bool is_null(int column) const { return sqlite3_column_type(handle_.get(), column) == SQLITE_NULL; }

private:
    struct Finalize {
        void operator()(sqlite3_stmt* handle) const { sqlite3_finalize(handle); }
    };

    void prepare(const char* sql);
    void bind(int place, std::int64_t value);
    void bind(int place, double value);
    void bind(int place, std::string_view value);
    template <class T>
    void bind(int place, const std::optional<T>& value) {
        if (value) bind(place, *value);  // else it is null already
    }

    Database& database_;
    std::unique_ptr<sqlite3_stmt, Finalize> handle_;
};

/// A transaction, undone at its end unless it was committed.
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
