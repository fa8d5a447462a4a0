// SPDX-License-Identifier: GPL-3.0-or-later
#include "server/jobs/sqlite_job_store.h"

#include <fcntl.h>
#include <sys/stat.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <exception>
#include <optional>
#include <type_traits>
#include <utility>

#include "server/processes/unique_fd.h"
#include "server/work/digest.h"

namespace ccdt::server {
namespace {

/// "ccdt" in ASCII, stored as SQLite's application id.
constexpr std::int64_t kApplication = 0x63636474;

/// Version of the tables.
constexpr std::int64_t kVersion = 1;

/// Bytes on disk that the log keeps, so that jobs can be deleted when the disk is full. Deleting a result of 36 MiB
/// needs 0.1 MB in the log; returning `kFreePages` pages needs 4.2 MB.
constexpr std::size_t kReserve = std::size_t{16} << 20;

/// Number of free pages that the database keeps. If it has more, this many pages are returned to the disk at a time.
constexpr std::int64_t kFreePages = 1024;

/// Number of jobs that one call deletes; more would delay other calls.
constexpr std::size_t kRemovedAtOnce = 100;

constexpr const char* kFile = "/jobs.sqlite";

constexpr const char* kDamagedJob = "the stored data of this job is damaged";

/// Every row has a digest of the data that was written, so that corruption by the disk is detected.
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

/// Returns a query for the columns that `job_at` reads, followed by the columns above. The last column is the digest of
/// all other columns.
std::string select_jobs(const std::string& which) {
    return "SELECT id, owner, client, memory, seconds, status, starts, created, started, finished, fraction, "
           "iteration, variation, failure, message, field, media_type, result_bytes, partial, dropped, row, bytes, "
           "traceparent, digest FROM jobs " +
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
    job.result_bytes = static_cast<std::size_t>(row.integer(17));
    job.partial = row.integer(18) != 0;
    job.dropped = row.integer(19) != 0;
    job.traceparent = row.text(kTraceparent);
    return job;
}

/// Returns the digest of a request. It includes the id of the job, so that a request cannot be mistaken for that of
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

ErrorCode code_of(const SqliteError& error) {
    switch (error.code()) {
        case SQLITE_FULL:
        case SQLITE_TOOBIG:
            return ErrorCode::LimitExceeded;
        case SQLITE_CORRUPT:
        case SQLITE_NOTADB:
            return ErrorCode::Unusable;
        default:
            return ErrorCode::Internal;
    }
}

/// Creates the file, readable and writable for its owner only.
Result<void> make_file(const std::string& folder, const std::string& path) {
    const auto failed = [](const std::string& name) {
        return failure(ErrorCode::Unusable, "the data folder cannot be used: " + name + ": " + std::strerror(errno));
    };
    if (mkdir(folder.c_str(), S_IRWXU) != 0 && errno != EEXIST) return failed(folder);
    if (!UniqueFd(::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, S_IRUSR | S_IWUSR))) return failed(path);
    return {};
}

}  // namespace

/// A stored job, its row, and the bytes that it takes.
struct SqliteJobStore::StoredJob {
    Job job;
    std::int64_t row = 0;
    std::size_t bytes = 0;

    /// Throws SQLITE_CORRUPT if the row does not match its digest.
    static StoredJob at(const Statement& row) {
        if (!is_sound(row)) damaged(kDamagedJob);
        return {job_at(row), row.integer(kRow), static_cast<std::size_t>(row.integer(kBytes))};
    }
};

/// A value with its stored digest.
template <class T>
struct SqliteJobStore::Sealed {
    T value;
    std::string digest;
};

Result<std::unique_ptr<SqliteJobStore>> SqliteJobStore::open(const std::string& folder, const JobLimits& limits) {
    const std::string path = folder.empty() ? ":memory:" : folder + kFile;
    if (!folder.empty()) {
        if (auto made = make_file(folder, path); !made) return tl::unexpected(made.error());
    }
    try {
        return std::unique_ptr<SqliteJobStore>(new SqliteJobStore(path, limits));
    } catch (const SqliteError& error) {
        const std::string reason = error.code() == SQLITE_BUSY ? "another server uses it" : error.what();
        return failure(ErrorCode::Unusable, "the jobs of " + path + " cannot be used: " + reason);
    }
}

SqliteJobStore::SqliteJobStore(const std::string& path, const JobLimits& limits) : limits_(limits), database_(path) {
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
    // By default, Debian's SQLite overwrites deleted data, which would need as much space in the log.
    database_.execute("PRAGMA secure_delete = FAST");
    database_.execute(("PRAGMA journal_size_limit = " + std::to_string(kReserve)).c_str());
    check_file();
    if (empty) create_tables();
    fail_damaged();
    bytes_ = static_cast<std::size_t>(database_.value_of("SELECT sum(bytes) FROM jobs"));
    queue_unfinished();
    cut_log();
}

/// Checks the file. Damaged indices are rebuilt.
void SqliteJobStore::check_file() {
    const auto fault = [this](const char* check) {
        Statement found(database_, check);
        found.step();
        return found.text(0) == "ok" ? "" : found.text(0);
    };
    if (fault("PRAGMA integrity_check(1)").empty()) return;
    if (const auto found = fault("PRAGMA quick_check(1)"); !found.empty())
        throw SqliteError(SQLITE_CORRUPT, "it is damaged: " + found);
    database_.execute("REINDEX");
    ++damages_;
}

void SqliteJobStore::create_tables() {
    Transaction transaction(database_);
    database_.execute(kTables);
    database_.execute(("PRAGMA application_id = " + std::to_string(kApplication)).c_str());
    database_.execute(("PRAGMA user_version = " + std::to_string(kVersion)).c_str());
    transaction.commit();
}

/// Fails the jobs whose rows do not match their digests.
void SqliteJobStore::fail_damaged() {
    std::vector<std::int64_t> rows;
    Statement query(database_, select_jobs("").c_str());
    while (query.step())
        if (!is_sound(query)) rows.push_back(query.integer(kRow));
    for (const auto row : rows) {
        Transaction transaction(database_);
        fail_damaged(row);
        transaction.commit();
    }
}

void SqliteJobStore::fail_damaged(std::int64_t row) {
    ++damages_;
    remove_bodies(row);
    Statement(database_,
              "UPDATE jobs SET status = ?, starts = 0, started = NULL, finished = ?, fraction = 0, iteration = 0, "
              "variation = NULL, failure = 500, message = ?, field = '', media_type = '', result_bytes = 0, "
              "partial = 0, dropped = 0, bytes = ? WHERE row = ?",
              static_cast<std::int64_t>(JobStatus::Failed), number_of(time_now()), kDamagedJob,
              number_of(bytes_of_job(0)), row)
        .run();
    seal(row);
}

/// Stores the digest of a job's row.
void SqliteJobStore::seal(std::int64_t row) {
    std::string digest;
    if (Statement query(database_, select_jobs("WHERE row = ?").c_str(), row); query.step()) digest = digest_of(query);
    Statement(database_, "UPDATE jobs SET digest = ? WHERE row = ?", digest, row).run();
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
        const ErrorCode code = code_of(error);
        if (code == ErrorCode::Unusable) ++damages_;
        if (code == ErrorCode::LimitExceeded) cut_log();
        return failure(code, std::string("the job store: ") + error.what());
    } catch (const std::exception& exception) {  // most likely out of memory
        return failure(ErrorCode::Internal, std::string("the job store: ") + exception.what());
    }
}

/// Runs a function that frees space, even if the disk is full.
template <class Do>
auto SqliteJobStore::run_freeing(Do act) -> Result<decltype(act())> {
    auto done = attempt(act);
    if (!done && done.error().code == ErrorCode::LimitExceeded) done = attempt(act);  // attempt() has emptied the log
    if (done) return_free_pages();
    return done;
}

/// Writes the contents of the log to the database file, where space is allocated, and truncates the log to the reserve.
void SqliteJobStore::cut_log() {
    try {
        database_.execute("PRAGMA wal_checkpoint(TRUNCATE)");
        database_.allocate_log(kReserve);
    } catch (const SqliteError&) {
        // The disk is full; a later call will succeed.
    }
}

/// Allocates space in the database file for data that is about to be written to the log.
void SqliteJobStore::allocate_space(std::size_t bytes) {
    constexpr std::int64_t kOthers = 64;  // pages of jobs and indices
    const auto page = database_.value_of("PRAGMA page_size");
    const auto more = number_of(bytes) / page + kOthers - database_.value_of("PRAGMA freelist_count");
    const auto pages = database_.value_of("PRAGMA page_count") + std::max<std::int64_t>(more, 0);
    database_.allocate(static_cast<std::size_t>(pages * page));
}

/// Moves the last pages to free pages before them, and truncates the file.
void SqliteJobStore::return_free_pages() {
    const auto free_pages = [this] { return database_.value_of("PRAGMA freelist_count"); };
    const auto step = [&] {
        const auto before = free_pages();
        if (before <= kFreePages) return false;
        database_.execute(("PRAGMA incremental_vacuum(" + std::to_string(kFreePages) + ")").c_str());
        database_.execute("PRAGMA wal_checkpoint(RESTART)");
        return free_pages() < before;
    };
    while (attempt(step).value_or(false)) {
    }
}

/// Queues the unfinished jobs in their original order.
void SqliteJobStore::queue_unfinished() {
    Statement query(database_, select_jobs("WHERE finished IS NULL ORDER BY row").c_str());
    while (query.step()) {
        const Job job = StoredJob::at(query).job;
        queue_.push(job.client, job.cost.seconds, {job.id, job.cost.memory});
    }
}

Result<bool> SqliteJobStore::is_full(std::string_view client) {
    const std::lock_guard lock(mutex_);
    return !accepts_job_of(client);
}

bool SqliteJobStore::accepts_job_of(std::string_view client) const {
    return queue_.size() < limits_.waiting || (queue_.size() < 2 * limits_.waiting && !queue_.has(client));
}

Result<JobStore::Added> SqliteJobStore::add(Job& job, const ComputeRequest& request) {
    const std::size_t bytes = bytes_of_job(bytes_of(request));
    const std::lock_guard space_lock(space_mutex_);
    if (is_full(job.client).value()) return Added::QueueFull;
    if (!free_space(bytes)) return Added::StoreFull;
    auto added = attempt([&] {
        if (look_up(job.id)) return Added::Accepted;
        job.created = time_now();
        insert(job, request, bytes);
        queue_.push(job.client, job.cost.seconds, {job.id, job.cost.memory});
        return Added::Accepted;
    });
    if (added == Added::Accepted) notifier_.notify([](JobListener& listener) { listener.work(); });
    return added;
}

/// Frees space: drops the oldest results and, if that is not enough, removes the jobs that finished first.
bool SqliteJobStore::free_space(std::size_t bytes) {
    const auto is_enough = [&] { return bytes_ + bytes <= limits_.bytes; };
    const auto drop = [&] {
        if (run_freeing([this] { return drop_oldest_result(); }).value_or(false)) return true;
        return run_freeing([this] { return remove_finished(Time::max(), 1); }).value_or(0) > 0;
    };
    while (!is_enough() && drop()) {
    }
    return is_enough();
}

/// Adds a job that does not exist yet.
void SqliteJobStore::insert(const Job& job, const ComputeRequest& request, std::size_t bytes) {
    allocate_space(bytes);
    Transaction transaction(database_);
    Statement(database_,
              "INSERT INTO jobs (id, owner, client, memory, seconds, status, starts, created, fraction, iteration, "
              "media_type, result_bytes, partial, dropped, bytes, traceparent) "
              "VALUES (?, ?, ?, ?, ?, ?, 0, ?, 0, 0, '', 0, 0, 0, ?, ?)",
              job.id, job.owner, job.client, number_of(job.cost.memory), job.cost.seconds,
              static_cast<std::int64_t>(job.status), number_of(job.created), number_of(bytes), job.traceparent)
        .run();
    const auto row = database_.last_row();
    seal(row);
    Statement(database_,
              "INSERT INTO questions (row, path, query, content_type, accept, body, digest) "
              "VALUES (?, ?, ?, ?, ?, zeroblob(?), ?)",
              row, request.path, request.query, request.content_type, request.accept, number_of(request.body.size()),
              digest_of(job.id, request))
        .run();
    database_.write_body("questions", row, request.body);
    transaction.commit();
    bytes_ += bytes;
    if (bytes > kReserve / 2) cut_log();
}

Result<std::optional<Job>> SqliteJobStore::claim(std::size_t memory) {
    return attempt([&]() -> std::optional<Job> {
        take_back_lost();
        while (auto entry = queue_.take_next_of([&](const Waiting& job) { return job.memory <= memory; }))
            if (auto job = begin(*std::move(entry))) return job;
        return std::nullopt;
    });
}

/// Requeues the jobs whose leases have expired.
void SqliteJobStore::take_back_lost() {
    const auto now = Clock::now();
    for (auto claimed = claimed_.begin(); claimed != claimed_.end();) {
        if (claimed->second.until > now) {
            ++claimed;
            continue;
        }
        queue_.put_back(std::move(claimed->second.entry));
        claimed = claimed_.erase(claimed);
    }
}

/// Starts a job that was taken from the queue.
/// @returns  none if the job cannot be run, because its data is damaged
std::optional<Job> SqliteJobStore::begin(Queue::Entry entry) {
    try {
        auto stored = look_up(entry.item.id);
        if (!stored) return std::nullopt;
        Job& job = stored->job;
        job.status = JobStatus::Queued;
        job.started.reset();
        job.progress = {};
        ++job.starts;
        Transaction transaction(database_);
        const std::size_t left = std::min(remove_pieces(stored->row), stored->bytes);  // stored by the previous claim
        update(job, stored->row, stored->bytes - left);
        transaction.commit();
        release(left);
        job.claim = ++last_claim_;
        claimed_.insert_or_assign(job.id, Claimed{std::move(entry), job, Clock::now() + limits_.lease});
        return std::move(job);
    } catch (const SqliteError& error) {
        if (code_of(error) != ErrorCode::Unusable) {
            queue_.put_back(std::move(entry));
            throw;
        }
        ++damages_;
        return std::nullopt;
    }
}

/// @returns  null if the claim is no longer valid
SqliteJobStore::Claimed* SqliteJobStore::find_claimed(const Job& job) {
    const auto found = claimed_.find(job.id);
    return found == claimed_.end() || found->second.job.claim != job.claim ? nullptr : &found->second;
}

Result<JobStore::Renewal> SqliteJobStore::renew(const Job& job) {
    auto held = attempt([&] {
        const Time now = time_now();
        if (Claimed* claimed = find_claimed(job)) {
            claimed->until = Clock::now() + limits_.lease;
            if (job.status == JobStatus::Running && !claimed->job.started) claimed->job.started = now;
            claimed->job.status = job.status;
            claimed->job.progress = job.progress;
            return Renewal{Owned::Still, now};
        }
        const auto stored = look_up(job.id);
        return Renewal{stored && stored->job.status == JobStatus::Cancelled ? Owned::Cancelled : Owned::Lost, now};
    });
    if (held && held->owned == Owned::Still) notifier_.notify([&](JobListener& listener) { listener.changed(job.id); });
    return held;
}

Result<void> SqliteJobStore::requeue(const Job& job) {
    auto given = attempt([&] {
        Claimed* claimed = find_claimed(job);
        if (claimed == nullptr) return;
        queue_.put_back(std::move(claimed->entry));
        claimed_.erase(job.id);
        auto stored = look_up(job.id);
        if (!stored) return;
        --stored->job.starts;
        Transaction transaction(database_);
        update(stored->job, stored->row, stored->bytes);
        transaction.commit();
    });
    notifier_.notify([&](JobListener& listener) {
        listener.changed(job.id);
        listener.work();
    });
    return given;
}

/// Removes a job from the queue and ends its claim.
void SqliteJobStore::withdraw(const std::string& id) {
    claimed_.erase(id);
    queue_.withdraw([&](const Waiting& job) { return job.id == id; });
}

/// @returns  none if there is no such job
template <class Value>
std::optional<SqliteJobStore::StoredJob> SqliteJobStore::look_up(const char* which, const Value& value) {
    Statement query(database_, select_jobs(which).c_str(), value);
    if (!query.step()) return std::nullopt;
    return StoredJob::at(query);
}

/// Looks up a job by its id. The id is compared, because a damaged index may lead to the row of another job.
std::optional<SqliteJobStore::StoredJob> SqliteJobStore::look_up(const std::string& id) {
    auto stored = look_up("WHERE id = ?", id);
    if (stored && stored->job.id != id) damaged("an index of the store is damaged");
    return stored;
}

std::optional<SqliteJobStore::Sealed<ComputeRequest>> SqliteJobStore::request_of(const StoredJob& stored) {
    Statement query(database_, "SELECT path, query, content_type, accept, digest FROM questions WHERE row = ?",
                    stored.row);
    if (!query.step()) return std::nullopt;
    return Sealed<ComputeRequest>{{query.text(0), query.text(1), query.text(2), query.text(3),
                                   database_.read_body("questions", stored.row, stored.bytes)},
                                  query.text(4)};
}

std::optional<SqliteJobStore::Sealed<std::string>> SqliteJobStore::piece_of(const StoredJob& stored,
                                                                            std::size_t number) {
    Statement query(database_, "SELECT row, digest FROM results WHERE job = ? AND number = ?", stored.row,
                    number_of(number));
    if (!query.step()) return std::nullopt;
    return Sealed<std::string>{database_.read_body("results", query.integer(0), stored.bytes), query.text(1)};
}

/// Finds a job with its current state. The database does not have the state of running jobs.
std::optional<SqliteJobStore::StoredJob> SqliteJobStore::find_stored(const std::string& id) {
    auto stored = look_up(id);
    if (!stored) return std::nullopt;
    Job& job = stored->job;
    if (job.finished) return *job.finished + limits_.ttl <= time_now() ? std::nullopt : std::move(stored);
    const auto claimed = claimed_.find(id);
    if (claimed != claimed_.end()) {
        job = claimed->second.job;
        return stored;
    }
    job.status = JobStatus::Queued;
    job.started.reset();
    job.progress = {};
    return stored;
}

Result<std::optional<Job>> SqliteJobStore::find(const std::string& id) {
    return attempt([&]() -> std::optional<Job> {
        auto stored = find_stored(id);
        if (!stored) return std::nullopt;
        return std::move(stored->job);
    });
}

Result<std::optional<ComputeRequest>> SqliteJobStore::request(const std::string& id) {
    return attempt([&]() -> std::optional<ComputeRequest> {
        const auto stored = look_up(id);
        auto request = stored ? request_of(*stored) : std::nullopt;
        if (!request) return std::nullopt;
        if (request->digest != digest_of(id, request->value)) damaged("the stored request is damaged");
        return std::move(request->value);
    });
}

Result<std::optional<std::string>> SqliteJobStore::piece(const std::string& id, std::size_t number) {
    return attempt([&]() -> std::optional<std::string> {
        const auto stored = look_up(id);
        if (!stored || stored->job.result_bytes == 0 || stored->job.dropped) return std::nullopt;
        auto piece = piece_of(*stored, number);
        if (!piece || piece->digest != digest_of_piece(id, number, piece->value))
            damaged("the stored result is damaged");
        return std::move(piece->value);
    });
}

/// @param bytes  bytes that the job takes from now on
void SqliteJobStore::update(const Job& job, std::int64_t row, std::size_t bytes) {
    std::optional<std::int64_t> failure;
    std::string message;
    std::optional<std::string_view> field;
    if (job.failure) {
        failure = job.failure->status;
        message = job.failure->error.message;
        field = job.failure->error.field;
    } else {  // jobs that have not failed store their headers as the message
        message = text_of(job.headers);
    }
    Statement(database_,
              "UPDATE jobs SET status = ?, starts = ?, started = ?, finished = ?, fraction = ?, iteration = ?, "
              "variation = ?, failure = ?, message = ?, field = ?, media_type = ?, result_bytes = ?, partial = ?, "
              "bytes = ? WHERE row = ?",
              static_cast<std::int64_t>(job.status), static_cast<std::int64_t>(job.starts), number_of(job.started),
              number_of(job.finished), job.progress.fraction, static_cast<std::int64_t>(job.progress.iteration),
              job.progress.variation, failure, message, field, job.media_type, number_of(job.result_bytes),
              static_cast<std::int64_t>(job.partial), number_of(bytes), row)
        .run();
    seal(row);
}

Result<bool> SqliteJobStore::append_piece(const Job& job, const StoredPart& before, std::string_view piece) {
    const std::size_t whole = before.bytes + piece.size();
    if (bytes_of_job(whole) > limits_.bytes) return no_space_for(whole);
    const std::lock_guard space_lock(space_mutex_);
    if (!free_space(piece.size())) return no_space_for(whole);
    return attempt([&] {
        const auto stored = find_claimed(job) != nullptr ? look_up(job.id) : std::nullopt;
        if (!stored) return false;
        allocate_space(piece.size());
        Transaction transaction(database_);
        insert_piece(*stored, before.pieces, piece);
        Statement(database_, "UPDATE jobs SET bytes = ? WHERE row = ?", number_of(stored->bytes + piece.size()),
                  stored->row)
            .run();
        seal(stored->row);
        transaction.commit();
        bytes_ += piece.size();
        return true;
    });
}

Result<std::optional<Time>> SqliteJobStore::finish(const Job& job, std::string_view result, const StoredPart& before) {
    const std::size_t whole = before.bytes + result.size();
    if (whole > 0 && bytes_of_job(whole) > limits_.bytes) return no_space_for(whole);
    const std::lock_guard space_lock(space_mutex_);
    if (!result.empty() && !free_space(result.size())) return no_space_for(whole);
    auto finished = attempt([&]() -> std::optional<Time> {
        const Claimed* claimed = find_claimed(job);
        const auto stored = claimed != nullptr ? look_up(job.id) : std::nullopt;
        if (!stored) return std::nullopt;
        Job ended = job;
        ended.finished = time_now();
        ended.result_bytes = whole;
        exchange(ended, *stored, result, before);
        claimed_.erase(job.id);
        return ended.finished;
    });
    if (finished && *finished) notifier_.notify([&](JobListener& listener) { listener.changed(job.id); });
    return finished;
}

/// Replaces the request of a job by its result, if there is one.
/// @param before  part of the result that is stored already
void SqliteJobStore::exchange(const Job& job, const StoredJob& stored, std::string_view result,
                              const StoredPart& before) {
    const std::size_t after = bytes_of_job(before.bytes + result.size());
    allocate_space(bytes_of_job(result.size()));
    Transaction transaction(database_);
    remove_question(stored.row);
    if (before.pieces == 0) remove_pieces(stored.row);
    if (!result.empty()) insert_piece(stored, before.pieces, result);
    update(job, stored.row, after);
    transaction.commit();
    bytes_ += after;
    release(stored.bytes);
    if (result.size() > kReserve / 2) cut_log();
}

void SqliteJobStore::insert_piece(const StoredJob& stored, std::size_t number, std::string_view piece) {
    Statement(database_, "INSERT INTO results (job, number, body, digest) VALUES (?, ?, zeroblob(?), ?)", stored.row,
              number_of(number), number_of(piece.size()), digest_of_piece(stored.job.id, number, piece))
        .run();
    database_.write_body("results", database_.last_row(), piece);
}

Result<std::optional<Job>> SqliteJobStore::cancel(const std::string& id) {
    auto cancelled = run_freeing([&]() -> std::optional<Job> {
        auto stored = find_stored(id);
        if (!stored || stored->job.finished) return std::nullopt;
        Job job = std::move(stored->job);
        job.status = JobStatus::Cancelled;
        job.finished = time_now();
        exchange(job, *stored, {}, {});
        withdraw(id);
        return job;
    });
    if (cancelled && *cancelled) {
        notifier_.notify([&](JobListener& listener) {
            listener.stop(id);
            listener.changed(id);
        });
    }
    return cancelled;
}

/// Subtracts freed bytes. A damaged row may claim more bytes than it had.
void SqliteJobStore::release(std::size_t bytes) {
    bytes_ -= std::min(bytes_.load(), bytes);
}

void SqliteJobStore::remove_question(std::int64_t row) {
    Statement(database_, "DELETE FROM questions WHERE row = ?", row).run();
}

/// Removes the stored pieces of a job's result.
/// @returns  their bytes
std::size_t SqliteJobStore::remove_pieces(std::int64_t row) {
    Statement sum(database_, "SELECT sum(length(body)) FROM results WHERE job = ?", row);
    const auto bytes = sum.step() ? static_cast<std::size_t>(sum.integer(0)) : 0;
    sum.run();
    Statement(database_, "DELETE FROM results WHERE job = ?", row).run();
    return bytes;
}

void SqliteJobStore::remove_bodies(std::int64_t row) {
    remove_question(row);
    remove_pieces(row);
}

/// Removes one row of jobs.
/// @returns  bytes that the row took
std::size_t SqliteJobStore::remove_row(std::int64_t row) {
    remove_bodies(row);
    Statement removed(database_, "DELETE FROM jobs WHERE row = ? RETURNING bytes", row);
    const auto bytes = removed.step() ? static_cast<std::size_t>(removed.integer(0)) : 0;
    removed.run();
    return bytes;
}

Result<bool> SqliteJobStore::remove(const std::string& id) {
    return run_freeing([&] {
        Transaction transaction(database_);
        std::optional<std::int64_t> row;
        if (Statement query(database_, "SELECT row FROM jobs WHERE id = ?", id); query.step()) row = query.integer(0);
        if (!row) return false;
        const std::size_t bytes = remove_row(*row);
        transaction.commit();
        release(bytes);
        withdraw(id);
        return true;
    });
}

/// Removes some of the jobs that had finished by `by`, oldest first.
/// @returns  number of removed jobs
std::size_t SqliteJobStore::remove_finished(Time by, std::size_t max_jobs) {
    Transaction transaction(database_);
    std::vector<std::int64_t> rows;
    Statement query(database_, "SELECT row FROM jobs WHERE finished <= ? ORDER BY finished LIMIT ?", number_of(by),
                    number_of(max_jobs));
    while (query.step()) rows.push_back(query.integer(0));
    std::size_t bytes = 0;
    for (const auto row : rows) bytes += remove_row(row);
    transaction.commit();
    release(bytes);
    return rows.size();
}

Result<bool> SqliteJobStore::remove_expired() {
    const auto remove = [this](std::size_t max_jobs) {
        return run_freeing([&] { return remove_finished(time_now() - limits_.ttl, max_jobs); });
    };
    auto removed = remove(kRemovedAtOnce);
    if (!removed && removed.error().code == ErrorCode::LimitExceeded) removed = remove(1);
    return removed.map([](std::size_t count) { return count == kRemovedAtOnce; });
}

Result<JobStore::Load> SqliteJobStore::load() {
    const std::lock_guard lock(mutex_);
    return Load{queue_.size(), claimed_.size(), bytes_};
}

/// Drops the oldest result: that of the job that finished first.
/// @returns  false if there is none
bool SqliteJobStore::drop_oldest_result() {
    Transaction transaction(database_);
    Statement oldest(database_,
                     select_jobs("WHERE result_bytes > 0 AND dropped = 0 ORDER BY finished LIMIT 1").c_str());
    if (!oldest.step()) return false;
    const auto row = oldest.integer(kRow);
    const auto before = static_cast<std::size_t>(oldest.integer(kBytes));
    const bool sound = is_sound(oldest);
    oldest.run();
    if (sound) {
        remove_bodies(row);
        Statement(database_, "UPDATE jobs SET dropped = 1, bytes = ? WHERE row = ?", number_of(bytes_of_job(0)), row)
            .run();
        seal(row);
    } else {
        fail_damaged(row);
    }
    transaction.commit();
    bytes_ += bytes_of_job(0);
    release(before);
    return true;
}

}  // namespace ccdt::server
