#include "server/jobs/sqlite_job_store.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstring>
#include <exception>
#include <optional>
#include <type_traits>
#include <utility>

#include "server/http/unique_fd.h"

namespace ccdt::server {
namespace {

/// "ccdt", where SQLite keeps whose file it is.
constexpr std::int64_t kApplication = 0x63636474;

constexpr std::int64_t kVersion = 1;

constexpr const char* kFile = "/jobs.sqlite";

constexpr const char* kTables = R"(
    CREATE TABLE jobs (
        row INTEGER PRIMARY KEY,
        id TEXT NOT NULL UNIQUE,
        owner TEXT NOT NULL,
        client TEXT NOT NULL,
        memory INTEGER NOT NULL,
        seconds REAL NOT NULL,
        status INTEGER NOT NULL,
        starts INTEGER NOT NULL,
        created INTEGER NOT NULL,
        started INTEGER,
        finished INTEGER,
        fraction REAL NOT NULL,
        iteration INTEGER NOT NULL,
        variation REAL,
        failure INTEGER,
        message TEXT,
        field TEXT,
        media_type TEXT NOT NULL,
        result_bytes INTEGER NOT NULL,
        partial INTEGER NOT NULL,
        dropped INTEGER NOT NULL,
        bytes INTEGER NOT NULL
    );
    CREATE INDEX unfinished_jobs ON jobs (row) WHERE finished IS NULL;
    CREATE INDEX finished_jobs ON jobs (finished) WHERE finished IS NOT NULL;
    CREATE INDEX results_kept ON jobs (finished) WHERE result_bytes > 0 AND dropped = 0;
    CREATE TABLE questions (
        row INTEGER PRIMARY KEY,
        path TEXT NOT NULL,
        query TEXT NOT NULL,
        content_type TEXT NOT NULL,
        accept TEXT NOT NULL,
        body BLOB NOT NULL
    );
    CREATE TABLE results (row INTEGER PRIMARY KEY, body BLOB NOT NULL);
)";

std::int64_t number_of(Time time) {
    return time.time_since_epoch().count();
}

std::optional<std::int64_t> number_of(std::optional<Time> time) {
    if (!time) return std::nullopt;
    return number_of(*time);
}

std::int64_t number_of(std::size_t size) {
    return static_cast<std::int64_t>(size);
}

Time time_of(std::int64_t number) {
    return Time(std::chrono::milliseconds(number));
}

std::optional<Time> time_at(const Statement& row, int column) {
    if (row.is_null(column)) return std::nullopt;
    return time_of(row.integer(column));
}

/// For `job_at`.
std::string select_jobs(const std::string& which) {
    return "SELECT id, owner, client, memory, seconds, status, starts, created, started, finished, fraction, "
           "iteration, variation, failure, message, field, media_type, result_bytes, partial, dropped FROM jobs " +
           which;
}

Job job_at(const Statement& row) {
    Job job;
    job.id = row.text(0);
    job.owner = row.text(1);
    job.client = row.text(2);
    job.cost = {static_cast<std::size_t>(row.integer(3)), row.real(4)};
    job.status = static_cast<JobStatus>(row.integer(5));
    job.starts = static_cast<int>(row.integer(6));
    job.created = time_of(row.integer(7));
    job.started = time_at(row, 8);
    job.finished = time_at(row, 9);
    job.progress = {row.real(10), static_cast<int>(row.integer(11)), {}};
    if (!row.is_null(12)) job.progress.variation = row.real(12);
    if (!row.is_null(13))
        job.failure = JobFailure{static_cast<int>(row.integer(13)), {ErrorCode::Internal, row.text(14), row.text(15)}};
    job.media_type = row.text(16);
    job.result_bytes = static_cast<std::size_t>(row.integer(17));
    job.partial = row.integer(18) != 0;
    job.dropped = row.integer(19) != 0;
    return job;
}

std::size_t size_of(const Question& question) {
    return question.path.size() + question.query.size() + question.content_type.size() + question.accept.size() +
           question.body.size();
}

Error error_of(const SqliteError& error) {
    const bool no_room = error.code() == SQLITE_FULL || error.code() == SQLITE_TOOBIG;
    return {
        no_room ? ErrorCode::LimitExceeded : ErrorCode::Internal, std::string("the job store: ") + error.what(), {}};
}

/// What it holds is for nobody else on the machine.
Result<void> make_file(const std::string& folder, const std::string& path) {
    const auto failed = [](const std::string& name) {
        return failure(ErrorCode::Unusable, "the data folder cannot be used: " + name + ": " + std::strerror(errno));
    };
    if (mkdir(folder.c_str(), S_IRWXU) != 0 && errno != EEXIST) return failed(folder);
    if (!UniqueFd(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, S_IRUSR | S_IWUSR))) return failed(path);
    return {};
}

}  // namespace

Result<std::unique_ptr<SqliteJobStore>> SqliteJobStore::open(const std::string& folder) {
    const std::string path = folder.empty() ? ":memory:" : folder + kFile;
    if (!folder.empty()) {
        if (auto made = make_file(folder, path); !made) return tl::unexpected(made.error());
    }
    try {
        return std::unique_ptr<SqliteJobStore>(new SqliteJobStore(path));
    } catch (const SqliteError& error) {
        const std::string reason = error.code() == SQLITE_BUSY ? "another server uses it" : error.what();
        return failure(ErrorCode::Unusable, "the jobs of " + path + " cannot be used: " + reason);
    }
}

SqliteJobStore::SqliteJobStore(const std::string& path) : database_(path) {
    database_.execute("PRAGMA locking_mode = EXCLUSIVE");
    const auto application = database_.value_of("PRAGMA application_id");
    const auto version = database_.value_of("PRAGMA user_version");
    const bool empty = database_.value_of("SELECT count(*) FROM sqlite_schema") == 0 && application == 0;
    if (!empty && application != kApplication) throw SqliteError(SQLITE_NOTADB, "it belongs to another program");
    if (!empty && version != kVersion)
        throw SqliteError(SQLITE_NOTADB,
                          "it is of version " + std::to_string(version) + ", not " + std::to_string(kVersion));
    database_.execute("PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL; PRAGMA journal_size_limit = 67108864");
    if (empty) prepare_tables();
    if (Statement check(database_, "PRAGMA quick_check(1)"); check.step() && check.text(0) != "ok")
        throw SqliteError(SQLITE_CORRUPT, "it is damaged: " + check.text(0));
    bytes_ = static_cast<std::size_t>(database_.value_of("SELECT sum(bytes) FROM jobs"));
}

void SqliteJobStore::prepare_tables() {
    Transaction transaction(database_);
    database_.execute(kTables);
    database_.execute(("PRAGMA application_id = " + std::to_string(kApplication)).c_str());
    database_.execute(("PRAGMA user_version = " + std::to_string(kVersion)).c_str());
    transaction.commit();
}

template <class Do>
auto SqliteJobStore::attempt(Do act) -> Result<decltype(act())> {
    const std::lock_guard lock(mutex_);
    try {
        if constexpr (std::is_void_v<decltype(act())>) {
            act();
            return {};
        } else {
            return act();
        }
    } catch (const SqliteError& error) {
        return tl::unexpected(error_of(error));
    } catch (const std::exception& exception) {  // no memory for a body, most likely
        return failure(ErrorCode::Internal, std::string("the job store: ") + exception.what());
    }
}

Result<void> SqliteJobStore::add(const Job& job, const Question& question) {
    return attempt([&] {
        const std::size_t bytes = bytes_of_job(size_of(question));
        Transaction transaction(database_);
        Statement(
            database_,
            "INSERT INTO jobs (id, owner, client, memory, seconds, status, starts, created, fraction, iteration, "
            "media_type, result_bytes, partial, dropped, bytes) VALUES (?, ?, ?, ?, ?, ?, 0, ?, 0, 0, '', 0, 0, 0, ?)",
            job.id, job.owner, job.client, number_of(job.cost.memory), job.cost.seconds,
            static_cast<std::int64_t>(job.status), number_of(job.created), number_of(bytes))
            .run();
        const auto row = database_.last_row();
        Statement(database_,
                  "INSERT INTO questions (row, path, query, content_type, accept, body) "
                  "VALUES (?, ?, ?, ?, ?, zeroblob(?))",
                  row, question.path, question.query, question.content_type, question.accept,
                  number_of(question.body.size()))
            .run();
        database_.write_body("questions", row, question.body);
        transaction.commit();
        bytes_ += bytes;
    });
}

Result<std::vector<Job>> SqliteJobStore::unfinished() {
    return attempt([&] {
        std::vector<Job> jobs;
        Statement query(database_, select_jobs("WHERE finished IS NULL ORDER BY row").c_str());
        while (query.step()) jobs.push_back(job_at(query));
        return jobs;
    });
}

Result<std::optional<Job>> SqliteJobStore::find(const std::string& id) {
    return attempt([&]() -> std::optional<Job> {
        Statement query(database_, select_jobs("WHERE id = ?").c_str(), id);
        if (!query.step()) return std::nullopt;
        return job_at(query);
    });
}

Result<std::optional<Question>> SqliteJobStore::question(const std::string& id) {
    return attempt([&]() -> std::optional<Question> {
        Statement query(database_,
                        "SELECT path, query, content_type, accept, row FROM questions "
                        "WHERE row = (SELECT row FROM jobs WHERE id = ?)",
                        id);
        if (!query.step()) return std::nullopt;
        return Question{query.text(0), query.text(1), query.text(2), query.text(3),
                        database_.read_body("questions", query.integer(4))};
    });
}

Result<std::optional<std::string>> SqliteJobStore::result(const std::string& id) {
    return attempt([&]() -> std::optional<std::string> {
        Statement query(database_, "SELECT row FROM results WHERE row = (SELECT row FROM jobs WHERE id = ?)", id);
        if (!query.step()) return std::nullopt;
        return database_.read_body("results", query.integer(0));
    });
}

/// @param bytes  that the job takes from now on; none: as many as before
void SqliteJobStore::update(const Job& job, std::optional<std::size_t> bytes) {
    std::optional<std::int64_t> failure;
    std::optional<std::string_view> message;
    std::optional<std::string_view> field;
    if (job.failure) {
        failure = job.failure->status;
        message = job.failure->error.message;
        field = job.failure->error.field;
    }
    std::optional<std::int64_t> new_bytes;
    if (bytes) new_bytes = number_of(*bytes);
    Statement(database_,
              "UPDATE jobs SET status = ?, starts = ?, started = ?, finished = ?, fraction = ?, iteration = ?, "
              "variation = ?, failure = ?, message = ?, field = ?, media_type = ?, result_bytes = ?, partial = ?, "
              "bytes = coalesce(?, bytes) WHERE id = ?",
              static_cast<std::int64_t>(job.status), static_cast<std::int64_t>(job.starts), number_of(job.started),
              number_of(job.finished), job.progress.fraction, static_cast<std::int64_t>(job.progress.iteration),
              job.progress.variation, failure, message, field, job.media_type, number_of(job.result_bytes),
              static_cast<std::int64_t>(job.partial), new_bytes, job.id)
        .run();
}

Result<void> SqliteJobStore::save(const Job& job) {
    return attempt([&] { update(job, {}); });
}

Result<void> SqliteJobStore::finish(const Job& job, std::string_view result) {
    return attempt([&] {
        Statement known(database_, "SELECT row, bytes FROM jobs WHERE id = ?", job.id);
        if (!known.step()) return;
        const auto row = known.integer(0);
        const auto before = static_cast<std::size_t>(known.integer(1));
        known.run();  // or it would keep the transaction open
        const std::size_t after = bytes_of_job(result.size());
        Transaction transaction(database_);
        Statement(database_, "DELETE FROM questions WHERE row = ?", row).run();
        if (!result.empty()) {
            Statement(database_, "INSERT INTO results (row, body) VALUES (?, zeroblob(?))", row,
                      number_of(result.size()))
                .run();
            database_.write_body("results", row, result);
        }
        update(job, after);
        transaction.commit();
        bytes_ += after - before;
    });
}

/// Of one row of jobs, or of none.
std::size_t SqliteJobStore::remove_row(std::int64_t row) {
    for (const char* statement : {"DELETE FROM questions WHERE row = ?", "DELETE FROM results WHERE row = ?"})
        Statement(database_, statement, row).run();
    Statement removed(database_, "DELETE FROM jobs WHERE row = ? RETURNING bytes", row);
    const auto bytes = removed.step() ? static_cast<std::size_t>(removed.integer(0)) : 0;
    removed.run();
    return bytes;
}

Result<bool> SqliteJobStore::remove(const std::string& id) {
    return attempt([&] {
        Transaction transaction(database_);
        std::optional<std::int64_t> row;
        if (Statement query(database_, "SELECT row FROM jobs WHERE id = ?", id); query.step()) row = query.integer(0);
        if (!row) return false;
        const std::size_t bytes = remove_row(*row);
        transaction.commit();
        bytes_ -= bytes;
        return true;
    });
}

Result<std::size_t> SqliteJobStore::remove_finished(Time by, std::size_t most) {
    return attempt([&] {
        Transaction transaction(database_);
        std::vector<std::int64_t> rows;
        Statement query(database_, "SELECT row FROM jobs WHERE finished <= ? ORDER BY finished LIMIT ?", number_of(by),
                        number_of(most));
        while (query.step()) rows.push_back(query.integer(0));
        std::size_t bytes = 0;
        for (const auto row : rows) bytes += remove_row(row);
        transaction.commit();
        bytes_ -= bytes;
        return rows.size();
    });
}

Result<std::optional<Time>> SqliteJobStore::first_finished() {
    return attempt([&] {
        Statement query(database_, "SELECT finished FROM jobs WHERE finished IS NOT NULL ORDER BY finished LIMIT 1");
        return query.step() ? time_at(query, 0) : std::nullopt;
    });
}

Result<bool> SqliteJobStore::drop_oldest_result() {
    return attempt([&] {
        Transaction transaction(database_);
        std::optional<std::int64_t> row;
        std::int64_t bytes = 0;
        if (Statement query(database_,
                            "SELECT row, result_bytes FROM jobs WHERE result_bytes > 0 AND dropped = 0 "
                            "ORDER BY finished LIMIT 1");
            query.step()) {
            row = query.integer(0);
            bytes = query.integer(1);
        }
        if (!row) return false;
        Statement(database_, "DELETE FROM results WHERE row = ?", *row).run();
        Statement(database_, "UPDATE jobs SET dropped = 1, bytes = bytes - result_bytes WHERE row = ?", *row).run();
        transaction.commit();
        bytes_ -= static_cast<std::size_t>(bytes);
        return true;
    });
}

}  // namespace ccdt::server
