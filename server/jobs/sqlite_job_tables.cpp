// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/sqlite_job_tables.h"

#include <algorithm>

#include "server/requests/digest.h"

namespace ccdt::server {
namespace {

/// The application id of the database file: "ccdt" in ASCII.
constexpr std::int64_t kApplication = 0x63636474;

/// Version of the tables.
constexpr std::int64_t kVersion = 1;

/// Bytes on disk reserved for the log, so that jobs can be deleted when the disk is full. Deleting a result of 36 MiB
/// needs 0.1 MB in the log; returning `kFreePages` pages needs 4.2 MB.
constexpr std::size_t kReserve = std::size_t{16} << 20;

/// Number of free pages above which free pages are returned to the disk, and maximum number of pages returned at a
/// time.
constexpr std::int64_t kFreePages = 1024;

constexpr const char* kDamagedJob = "the stored data of this job is damaged";
constexpr const char* kDamagedResult = "the stored result is damaged";

/// The tables. Every row has a digest of its data, so that corruption by the disk is detected.
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
        bytes INTEGER NOT NULL,
        traceparent TEXT NOT NULL,
        digest TEXT NOT NULL DEFAULT ''
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
        body BLOB NOT NULL,
        digest TEXT NOT NULL
    );
    CREATE TABLE results (
        row INTEGER PRIMARY KEY,
        job INTEGER NOT NULL,
        number INTEGER NOT NULL,
        body BLOB NOT NULL,
        digest TEXT NOT NULL
    );
    CREATE UNIQUE INDEX pieces_of_results ON results (job, number);
)";

/// The table of webhooks that are not sent yet, by the rows of their jobs. It was added without a new version of the
/// tables, so that earlier releases can use the file. If they remove a job, its webhook remains, and has a wrong
/// digest.
constexpr const char* kWebhooks = R"(
    CREATE TABLE IF NOT EXISTS webhooks (
        row INTEGER PRIMARY KEY,
        url TEXT NOT NULL,
        attempts INTEGER NOT NULL,
        due INTEGER NOT NULL,
        digest TEXT NOT NULL
    );
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

constexpr int kRow = 20;
constexpr int kBytes = 21;
constexpr int kTraceparent = 22;
constexpr int kDigest = 23;
constexpr int kCallback = 24;

/// Returns a query for the columns that job_at() reads, of which kDigest is the digest of all columns before it.
std::string select_jobs(const std::string& which) {
    return "SELECT id, owner, client, memory, seconds, status, starts, created, started, finished, fraction, "
           "iteration, variation, failure, message, field, media_type, result_bytes, partial, dropped, row, bytes, "
           "traceparent, digest, (SELECT url FROM webhooks WHERE webhooks.row = jobs.row) FROM jobs " +
           which;
}

std::string digest_of(const Statement& row) {
    Digest digest;
    for (int column = 0; column < kDigest; ++column) digest.add(row.image(column));
    return digest.finish();
}

/// Whether a row matches its digest.
bool is_sound(const Statement& row) {
    return row.text(kDigest) == digest_of(row);
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
        job.failure = Problem{static_cast<int>(row.integer(13)), {ErrorCode::Internal, row.text(14), row.text(15)}};
    if (row.is_null(13)) job.headers = headers_in(row.text(14));
    job.media_type = row.text(16);
    job.expected = static_cast<std::size_t>(std::max<std::int64_t>(-row.integer(17), 0));
    job.result_bytes = static_cast<std::size_t>(std::max<std::int64_t>(row.integer(17), 0));
    job.partial = row.integer(18) != 0;
    job.dropped = row.integer(19) != 0;
    job.traceparent = row.text(kTraceparent);
    job.callback = row.text(kCallback);
    return job;
}

/// Returns the digest of a request together with the id of its job. The id reveals a row that contains the request of
/// another job.
std::string digest_of(std::string_view id, const ComputeRequest& request) {
    Digest digest;
    for (const std::string_view text :
         {id, std::string_view(request.path), std::string_view(request.query), std::string_view(request.content_type),
          std::string_view(request.accept), std::string_view(request.body)})
        digest.add(text);
    return digest.finish();
}

[[noreturn]] void damaged(const char* message) {
    throw SqliteError(SQLITE_CORRUPT, message);
}

/// Reads a job. Throws SQLITE_CORRUPT if the row does not match its digest.
SqliteJobTables::StoredJob stored_job_at(const Statement& row) {
    if (!is_sound(row)) damaged(kDamagedJob);
    return {job_at(row), row.integer(kRow), static_cast<std::size_t>(row.integer(kBytes))};
}

/// Checks the file, and rebuilds damaged indices. Throws SQLITE_CORRUPT for other damage.
/// @returns  number of repairs, 0 or 1
std::uint64_t repair_indices(Database& database) {
    const auto fault = [&database](const char* check) {
        Statement found(database, check);
        found.step();
        return found.text(0) == "ok" ? "" : found.text(0);
    };
    if (fault("PRAGMA integrity_check(1)").empty()) return 0;
    if (const auto found = fault("PRAGMA quick_check(1)"); !found.empty())
        throw SqliteError(SQLITE_CORRUPT, "it is damaged: " + found);
    database.execute("REINDEX");
    return 1;
}

/// Computes and stores the digest of a job's row.
void seal(Database& database, std::int64_t row) {
    std::string digest;
    if (Statement query(database, select_jobs("WHERE row = ?").c_str(), row); query.step()) digest = digest_of(query);
    Statement(database, "UPDATE jobs SET digest = ? WHERE row = ?", digest, row).run();
}

/// Returns the column `result_bytes` of a job. Before the end of the job, it is the expected size, below zero.
std::int64_t result_column(const Job& job) {
    return job.finished ? number_of(job.result_bytes) : -number_of(job.expected);
}

/// Writes the state of a job to its row.
/// @param bytes  new number of bytes that the job takes
void write_job(Database& database, const Job& job, std::int64_t row, std::size_t bytes) {
    std::optional<std::int64_t> failure;
    std::string message;
    std::optional<std::string_view> field;
    if (job.failure) {
        failure = job.failure->status;
        message = job.failure->error.message;
        field = job.failure->error.field;
    } else {  // otherwise, the column `message` has the headers
        message = text_of(job.headers);
    }
    Statement(database,
              "UPDATE jobs SET status = ?, starts = ?, started = ?, finished = ?, fraction = ?, iteration = ?, "
              "variation = ?, failure = ?, message = ?, field = ?, media_type = ?, result_bytes = ?, partial = ?, "
              "dropped = ?, bytes = ? WHERE row = ?",
              static_cast<std::int64_t>(job.status), static_cast<std::int64_t>(job.starts), number_of(job.started),
              number_of(job.finished), job.progress.fraction, static_cast<std::int64_t>(job.progress.iteration),
              job.progress.variation, failure, message, field, job.media_type, result_column(job),
              static_cast<std::int64_t>(job.partial), static_cast<std::int64_t>(job.dropped), number_of(bytes), row)
        .run();
    seal(database, row);
}

void insert_piece(Database& database, const SqliteJobTables::StoredJob& stored, std::size_t number,
                  std::string_view piece) {
    Statement(database, "INSERT INTO results (job, number, body, digest) VALUES (?, ?, zeroblob(?), ?)", stored.row,
              number_of(number), number_of(piece.size()), digest_of_piece(stored.job.id, number, piece))
        .run();
    database.write_body("results", database.last_row(), piece);
}

void remove_question(Database& database, std::int64_t row) {
    Statement(database, "DELETE FROM questions WHERE row = ?", row).run();
}

/// Removes the stored pieces of a job's result.
/// @returns  size of the removed pieces, in bytes
std::size_t remove_pieces(Database& database, std::int64_t row) {
    Statement sum(database, "SELECT sum(length(body)) FROM results WHERE job = ?", row);
    const auto bytes = sum.step() ? static_cast<std::size_t>(sum.integer(0)) : 0;
    sum.run();
    Statement(database, "DELETE FROM results WHERE job = ?", row).run();
    return bytes;
}

void remove_bodies(Database& database, std::int64_t row) {
    remove_question(database, row);
    remove_pieces(database, row);
}

void remove_webhook(Database& database, std::int64_t row) {
    Statement(database, "DELETE FROM webhooks WHERE row = ?", row).run();
}

/// Removes a job with its request and result.
/// @returns  bytes that the job took
std::size_t remove_row(Database& database, std::int64_t row) {
    remove_bodies(database, row);
    remove_webhook(database, row);
    Statement removed(database, "DELETE FROM jobs WHERE row = ? RETURNING bytes", row);
    const auto bytes = removed.step() ? static_cast<std::size_t>(removed.integer(0)) : 0;
    removed.run();
    return bytes;
}

}  // namespace

SqliteJobTables::SqliteJobTables(const std::string& path) : database_(path) {
    database_.execute("PRAGMA locking_mode = EXCLUSIVE");
    const auto application = database_.value_of("PRAGMA application_id");
    const auto version = database_.value_of("PRAGMA user_version");
    const bool empty = database_.value_of("SELECT count(*) FROM sqlite_schema") == 0 && application == 0;
    if (!empty && application != kApplication) throw SqliteError(SQLITE_NOTADB, "it belongs to another program");
    if (!empty && version != kVersion)
        throw SqliteError(SQLITE_NOTADB,
                          "it has version " + std::to_string(version) + ", not " + std::to_string(kVersion));
    if (empty) database_.execute("PRAGMA auto_vacuum = INCREMENTAL");
    database_.execute("PRAGMA journal_mode = WAL; PRAGMA synchronous = FULL");
    // By default, Debian's SQLite overwrites deleted data, which would need the same space in the log.
    database_.execute("PRAGMA secure_delete = FAST");
    database_.execute(("PRAGMA journal_size_limit = " + std::to_string(kReserve)).c_str());
    damages_ += repair_indices(database_);
    if (empty) create();
    database_.execute(kWebhooks);
    fail_damaged_jobs();
    bytes_ = static_cast<std::size_t>(database_.value_of("SELECT sum(bytes) FROM jobs"));
    cut_log();
}

void SqliteJobTables::create() {
    Transaction transaction(database_);
    database_.execute(kTables);
    database_.execute(("PRAGMA application_id = " + std::to_string(kApplication)).c_str());
    database_.execute(("PRAGMA user_version = " + std::to_string(kVersion)).c_str());
    transaction.commit();
}

/// Marks the jobs whose rows do not match their digests as failed.
void SqliteJobTables::fail_damaged_jobs() {
    std::vector<std::int64_t> rows;
    Statement query(database_, select_jobs("").c_str());
    while (query.step())
        if (!is_sound(query)) rows.push_back(query.integer(kRow));
    for (const auto row : rows) {
        Transaction transaction(database_);
        fail_damaged_job(row);
        transaction.commit();
    }
}

void SqliteJobTables::fail_damaged_job(std::int64_t row) {
    ++damages_;
    remove_bodies(database_, row);
    Job job;
    job.status = JobStatus::Failed;
    job.finished = time_now();
    job.failure = Problem{500, {ErrorCode::Internal, kDamagedJob, {}}};
    write_job(database_, job, row, JobStore::bytes_of_job(0));
}

std::vector<Job> SqliteJobTables::unfinished() {
    std::vector<Job> jobs;
    Statement query(database_, select_jobs("WHERE finished IS NULL ORDER BY row").c_str());
    while (query.step()) jobs.push_back(stored_job_at(query).job);
    return jobs;
}

/// Also compares the id, because a damaged index may lead to the row of another job.
std::optional<SqliteJobTables::StoredJob> SqliteJobTables::find(const std::string& id) {
    Statement query(database_, select_jobs("WHERE id = ?").c_str(), id);
    if (!query.step()) return std::nullopt;
    auto stored = stored_job_at(query);
    if (stored.job.id != id) damaged("an index of the store is damaged");
    return stored;
}

std::optional<ComputeRequest> SqliteJobTables::request(const std::string& id) {
    const auto stored = find(id);
    if (!stored) return std::nullopt;
    Statement query(database_, "SELECT path, query, content_type, accept, digest FROM questions WHERE row = ?",
                    stored->row);
    if (!query.step()) return std::nullopt;
    ComputeRequest request{query.text(0), query.text(1), query.text(2), query.text(3),
                           database_.read_body("questions", stored->row, stored->bytes)};
    if (query.text(4) != digest_of(id, request)) damaged("the stored request is damaged");
    return request;
}

std::optional<std::string> SqliteJobTables::piece(const std::string& id, std::size_t number) {
    const auto stored = find(id);
    if (!stored || stored->job.result_bytes == 0 || stored->job.dropped) return std::nullopt;
    Statement query(database_, "SELECT row, digest FROM results WHERE job = ? AND number = ?", stored->row,
                    number_of(number));
    if (!query.step()) damaged(kDamagedResult);
    auto piece = database_.read_body("results", query.integer(0), stored->bytes);
    if (query.text(1) != digest_of_piece(id, number, piece)) damaged(kDamagedResult);
    return piece;
}

void SqliteJobTables::insert(const Job& job, const ComputeRequest& request, std::size_t max_bytes) {
    const std::size_t bytes = JobStore::bytes_of_job(JobStore::bytes_of(request));
    const std::size_t results = std::min(promised(job.expected), max_bytes - std::min(max_bytes, bytes_ + bytes));
    database_.allocate_log(kReserve / 2);
    allocate_space(bytes + results);
    Transaction transaction(database_);
    Statement(database_,
              "INSERT INTO jobs (id, owner, client, memory, seconds, status, starts, created, fraction, iteration, "
              "media_type, result_bytes, partial, dropped, bytes, traceparent) "
              "VALUES (?, ?, ?, ?, ?, ?, 0, ?, 0, 0, '', ?, 0, 0, ?, ?)",
              job.id, job.owner, job.client, number_of(job.cost.memory), job.cost.seconds,
              static_cast<std::int64_t>(job.status), number_of(job.created), result_column(job), number_of(bytes),
              job.traceparent)
        .run();
    const auto row = database_.last_row();
    seal(database_, row);
    Statement(database_,
              "INSERT INTO questions (row, path, query, content_type, accept, body, digest) "
              "VALUES (?, ?, ?, ?, ?, zeroblob(?), ?)",
              row, request.path, request.query, request.content_type, request.accept, number_of(request.body.size()),
              digest_of(job.id, request))
        .run();
    database_.write_body("questions", row, request.body);
    if (!job.callback.empty())
        Statement(database_, "INSERT OR REPLACE INTO webhooks (row, url, attempts, due, digest) VALUES (?, ?, 0, 0, ?)",
                  row, job.callback, digest_of_piece(job.id, 0, job.callback))
            .run();
    transaction.commit();
    bytes_ += bytes;
    if (bytes > kReserve / 2) cut_log();
}

void SqliteJobTables::update(const StoredJob& stored) {
    Transaction transaction(database_);
    write_job(database_, stored.job, stored.row, stored.bytes);
    transaction.commit();
}

void SqliteJobTables::restart(const StoredJob& stored) {
    Transaction transaction(database_);
    const std::size_t removed = std::min(remove_pieces(database_, stored.row), stored.bytes);
    write_job(database_, stored.job, stored.row, stored.bytes - removed);
    transaction.commit();
    release(removed);
}

void SqliteJobTables::append(const StoredJob& stored, std::size_t number, std::string_view piece) {
    allocate_space(piece.size());
    Transaction transaction(database_);
    insert_piece(database_, stored, number, piece);
    write_job(database_, stored.job, stored.row, stored.bytes + piece.size());
    transaction.commit();
    bytes_ += piece.size();
}

void SqliteJobTables::finish(const Job& job, const StoredJob& stored, std::string_view result,
                             const JobStore::StoredPart& before) {
    const std::size_t after = JobStore::bytes_of_job(before.bytes + result.size());
    allocate_space(JobStore::bytes_of_job(result.size()));
    Transaction transaction(database_);
    remove_question(database_, stored.row);
    if (before.pieces == 0) remove_pieces(database_, stored.row);
    if (!result.empty()) insert_piece(database_, stored, before.pieces, result);
    write_job(database_, job, stored.row, after);
    transaction.commit();
    bytes_ += after;
    release(stored.bytes);
    if (result.size() > kReserve / 2) cut_log();
}

std::optional<JobStore::Webhook> SqliteJobTables::claim_webhook(Time now, Time until) {
    Transaction transaction(database_);
    Statement query(database_,
                    "SELECT row, id, url, attempts, webhooks.digest FROM webhooks JOIN jobs USING (row) "
                    "WHERE due <= ? AND finished IS NOT NULL ORDER BY due LIMIT 1",
                    number_of(now));
    if (!query.step()) return std::nullopt;
    const auto row = query.integer(0);
    const std::string id = query.text(1), url = query.text(2);
    const auto attempts = query.integer(3) + 1;
    const bool sound = query.text(4) == digest_of_piece(id, 0, url);
    query.run();
    if (sound)
        Statement(database_, "UPDATE webhooks SET attempts = ?, due = ? WHERE row = ?", attempts, number_of(until), row)
            .run();
    else
        remove_webhook(database_, row);
    transaction.commit();
    auto stored = sound ? find(id) : std::nullopt;
    if (!stored) return std::nullopt;
    return JobStore::Webhook{std::move(stored->job), static_cast<int>(attempts)};
}

void SqliteJobTables::settle_webhook(const std::string& id, std::optional<Time> due) {
    const auto stored = find(id);
    if (!stored) return;
    if (due)
        Statement(database_, "UPDATE webhooks SET due = ? WHERE row = ?", number_of(*due), stored->row).run();
    else
        remove_webhook(database_, stored->row);
}

bool SqliteJobTables::remove(const std::string& id) {
    Transaction transaction(database_);
    std::optional<std::int64_t> row;
    if (Statement query(database_, "SELECT row FROM jobs WHERE id = ?", id); query.step()) row = query.integer(0);
    if (!row) return false;
    const std::size_t bytes = remove_row(database_, *row);
    transaction.commit();
    release(bytes);
    return true;
}

std::size_t SqliteJobTables::remove_finished(Time by, std::size_t max_jobs) {
    Transaction transaction(database_);
    std::vector<std::int64_t> rows;
    Statement query(database_, "SELECT row FROM jobs WHERE finished <= ? ORDER BY finished LIMIT ?", number_of(by),
                    number_of(max_jobs));
    while (query.step()) rows.push_back(query.integer(0));
    std::size_t bytes = 0;
    for (const auto row : rows) bytes += remove_row(database_, row);
    transaction.commit();
    release(bytes);
    return rows.size();
}

bool SqliteJobTables::drop_oldest_result() {
    Transaction transaction(database_);
    Statement oldest(database_,
                     select_jobs("WHERE result_bytes > 0 AND dropped = 0 ORDER BY finished LIMIT 1").c_str());
    if (!oldest.step()) return false;
    const auto row = oldest.integer(kRow);
    const auto before = static_cast<std::size_t>(oldest.integer(kBytes));
    auto job = is_sound(oldest) ? std::optional(job_at(oldest)) : std::nullopt;
    oldest.run();
    if (job) {
        job->dropped = true;
        remove_bodies(database_, row);
        write_job(database_, *job, row, JobStore::bytes_of_job(0));
    } else {
        fail_damaged_job(row);
    }
    transaction.commit();
    bytes_ += JobStore::bytes_of_job(0);
    release(before);
    return true;
}

void SqliteJobTables::cut_log() {
    try {
        database_.execute("PRAGMA wal_checkpoint(TRUNCATE)");
        database_.allocate_log(kReserve);
    } catch (const SqliteError&) {
        // The disk is full; a later call may succeed.
    }
}

bool SqliteJobTables::return_free_pages() {
    const auto free_pages = [this] { return database_.value_of("PRAGMA freelist_count"); };
    const auto before = free_pages();
    if (before <= kFreePages) return false;
    // Moves pages at the end of the file to free pages before them, and truncates the file.
    database_.execute(("PRAGMA incremental_vacuum(" + std::to_string(kFreePages) + ")").c_str());
    database_.execute("PRAGMA wal_checkpoint(RESTART)");
    return free_pages() < before;
}

/// Returns the disk space for the results of unfinished jobs, without the parts that are stored already.
/// @param more  expected size of the result of a further job
std::size_t SqliteJobTables::promised(std::size_t more) {
    constexpr double kLinks = 1.01;  // SQLite's links between the pages of a body
    // Two pages of each body are not full.
    const auto bytes = database_.value_of(
        "SELECT 8192 + total(8192 + max(0, -result_bytes - (SELECT total(length(body)) FROM results WHERE job = "
        "jobs.row))) FROM jobs INDEXED BY unfinished_jobs WHERE finished IS NULL");
    return static_cast<std::size_t>(kLinks * (static_cast<double>(bytes) + static_cast<double>(more)));
}

/// Allocates space in the database file for data that is about to be written to the log.
void SqliteJobTables::allocate_space(std::size_t bytes) {
    constexpr std::int64_t kOthers = 64;  // pages for the job's row and the indices
    const auto page = database_.value_of("PRAGMA page_size");
    const auto more = number_of(bytes) / page + kOthers - database_.value_of("PRAGMA freelist_count");
    const auto pages = database_.value_of("PRAGMA page_count") + std::max<std::int64_t>(more, 0);
    database_.allocate(static_cast<std::size_t>(pages * page));
}

/// Subtracts freed bytes, but never more than are counted, because the number in a damaged row may be too large.
void SqliteJobTables::release(std::size_t bytes) {
    bytes_ -= std::min(bytes_.load(), bytes);
}

}  // namespace ccdt::server
