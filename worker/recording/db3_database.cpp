#include "worker/recording/db3_database.hpp"

#include <new>
#include <sqlite3.h>
#include <string>
#include <utility>

#include "schemas/error.hpp"
#include "worker/recording/container.hpp"

namespace divemesh::recording {
namespace {

// The steps of SQLite's machine in which the schema of a bag is read many times over.
constexpr int kSchemaSteps = 1'000'000;
// A bag has six tables of a few columns.
constexpr int kMaxSql_bytes = 100'000;
constexpr int kMaxColumns = 100;
constexpr int kMaxDepth = 100;

[[noreturn]] void fail(const std::filesystem::path& path, const std::string& what) {
    throw Error(ErrorCode::BadData,
                path.string() + " " + what +
                    ": give the .db3 file of a ROS 2 bag, or copy it again from the recorder");
}

// Returns a path as a URI that names exactly this file.
std::string uri_of(const std::filesystem::path& path, const char* options) {
    constexpr const char* kHex = "0123456789ABCDEF";
    std::string uri = "file:";
    for (const char letter : std::filesystem::absolute(path).string()) {
        if (letter == '?' || letter == '#' || letter == '%') {
            uri += '%';
            uri += kHex[static_cast<unsigned char>(letter) >> 4U];
            uri += kHex[static_cast<unsigned char>(letter) & 15U];
        } else {
            uri += letter;
        }
    }
    return uri + options;
}

std::int64_t size_of_log(const std::filesystem::path& path) {
    std::error_code failure;
    const auto size = std::filesystem::file_size(path.string() + "-wal", failure);
    return failure ? 0 : static_cast<std::int64_t>(size);
}

// Returns whether the file ends before the pages that its header counts (sqlite.org/fileformat2).
bool ends_early(const InputFile& file) {
    const std::string head = file.read(0, 100);
    if (head.size() < 100) return true;
    const auto number = [&](std::size_t at, std::size_t num_bytes) {
        std::int64_t value = 0;
        for (std::size_t i = at; i < at + num_bytes; ++i)
            value = value * 256 + static_cast<unsigned char>(head[i]);
        return value;
    };
    const std::int64_t page_bytes = number(16, 2) == 1 ? 65536 : number(16, 2);
    if (number(24, 4) != number(92, 4)) return false;  // the count is not kept
    return file.size_bytes() < page_bytes * number(28, 4);
}

}  // namespace

void Db3Query::Finalize::operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }

Db3Query::Db3Query(sqlite3* database, std::string_view sql) {
    sqlite3_stmt* prepared = nullptr;
    const int code =
        sqlite3_prepare_v2(database, sql.data(), static_cast<int>(sql.size()), &prepared, nullptr);
    statement_.reset(prepared);
    if (code == SQLITE_NOMEM) throw std::bad_alloc();
    if (code != SQLITE_OK) throw Error(ErrorCode::BadData, sqlite3_errmsg(database));
}

void Db3Query::restart() { sqlite3_reset(statement_.get()); }

void Db3Query::bind(int place, std::int64_t value) {
    sqlite3_bind_int64(statement_.get(), place, value);
}

Db3Step Db3Query::step() {
    const int code = sqlite3_step(statement_.get());
    if (code == SQLITE_NOMEM) throw std::bad_alloc();
    if (code == SQLITE_ROW) return Db3Step::Row;
    return code == SQLITE_DONE ? Db3Step::Done : Db3Step::Damaged;
}

std::int64_t Db3Query::integer(int column) const {
    return sqlite3_column_int64(statement_.get(), column);
}

std::string_view Db3Query::bytes(int column) const {
    const auto* first = static_cast<const char*>(sqlite3_column_blob(statement_.get(), column));
    const int num_bytes = sqlite3_column_bytes(statement_.get(), column);
    return first == nullptr ? std::string_view()
                            : std::string_view(first, static_cast<std::size_t>(num_bytes));
}

bool Db3Query::is_blob(int column) const {
    return sqlite3_column_type(statement_.get(), column) == SQLITE_BLOB;
}

void Db3Database::Close::operator()(sqlite3* database) const { sqlite3_close(database); }

// With its log the database is opened by the VFS that locks nothing, so that no index of the log is
// made beside it; without, as a file that cannot change.
Db3Database::Db3Database(const std::filesystem::path& path) : log_bytes_(size_of_log(path)) {
    const bool with_log = log_bytes_ > 0;
    is_cut_ = !with_log && ends_early(InputFile(path));
    sqlite3* opened = nullptr;
    const int code = sqlite3_open_v2(
        uri_of(path, with_log ? "?mode=ro" : "?mode=ro&immutable=1").c_str(),
        &opened,
        SQLITE_OPEN_READONLY | SQLITE_OPEN_URI | SQLITE_OPEN_PRIVATECACHE | SQLITE_OPEN_NOMUTEX,
        with_log ? "unix-none" : "unix");
    database_.reset(opened);
    if (!opened) throw std::bad_alloc();
    if (code != SQLITE_OK) fail(path, std::string("cannot be opened: ") + sqlite3_errmsg(opened));
    limit();
    sqlite3_progress_handler(
        opened, kSchemaSteps, [](void*) { return 1; }, nullptr);
    std::string problem;
    try {
        if (with_log) query("PRAGMA locking_mode = EXCLUSIVE").step();
        query("PRAGMA cell_size_check = ON").step();
        problem = problem_of_schema();
    } catch (const Error& error) {
        problem = error.what();
    }
    if (!problem.empty()) fail(path, "is no ROS 2 bag: " + problem);
    sqlite3_progress_handler(opened, 0, nullptr, nullptr);
}

void Db3Database::limit() {
    sqlite3* database = database_.get();
    for (const auto& [option, value] : {std::pair(SQLITE_DBCONFIG_DEFENSIVE, is_cut_ ? 0 : 1),
                                        // Lets SQLite read a file that is cut; it cannot write.
                                        std::pair(SQLITE_DBCONFIG_WRITABLE_SCHEMA, is_cut_ ? 1 : 0),
                                        std::pair(SQLITE_DBCONFIG_TRUSTED_SCHEMA, 0),
                                        std::pair(SQLITE_DBCONFIG_ENABLE_TRIGGER, 0),
                                        std::pair(SQLITE_DBCONFIG_ENABLE_VIEW, 0),
                                        std::pair(SQLITE_DBCONFIG_NO_CKPT_ON_CLOSE, 1)})
        sqlite3_db_config(database, option, value, static_cast<int*>(nullptr));
    for (const auto& [limit, value] :
         {std::pair(SQLITE_LIMIT_LENGTH, static_cast<int>(kMaxBlock_bytes)),
          std::pair(SQLITE_LIMIT_SQL_LENGTH, kMaxSql_bytes),
          std::pair(SQLITE_LIMIT_COLUMN, kMaxColumns),
          std::pair(SQLITE_LIMIT_EXPR_DEPTH, kMaxDepth),
          std::pair(SQLITE_LIMIT_ATTACHED, 0)})
        sqlite3_limit(database, limit, value);
}

std::string Db3Database::problem_of_schema() const {
    auto entries = query(
        "SELECT count(*) FROM sqlite_schema WHERE type NOT IN ('table', 'index') OR "
        "sql LIKE 'CREATE VIRTUAL%'");
    if (entries.step() != Db3Step::Row) return "its schema cannot be read";
    if (entries.integer(0) > 0) return "it has views, triggers or virtual tables";
    for (const char* table : {"PRAGMA table_xinfo(topics)", "PRAGMA table_xinfo(messages)"}) {
        auto columns = query(table);
        while (columns.step() == Db3Step::Row)
            if (columns.integer(6) != 0 || columns.bytes(1) == "rowid")
                return "it has computed columns";
    }
    return "";
}

}  // namespace divemesh::recording
