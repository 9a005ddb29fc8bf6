#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>

struct sqlite3;
struct sqlite3_stmt;

namespace divemesh::recording {

// What a step of a query came to.
enum class Db3Step { Row, Done, Damaged };

// A query of a Db3Database, which has to outlive it.
class Db3Query {
public:
    // Throws Error{BadData} if the database has no such tables or columns.
    Db3Query(sqlite3* database, std::string_view sql);

    // Begins from the first row again, with the values that are bound next.
    void restart();
    void bind(int place, std::int64_t value);  // from 1
    // Steps to the next row, whose values live until the next step.
    Db3Step step();
    std::int64_t integer(int column) const;  // from 0
    std::string_view bytes(int column) const;
    bool is_blob(int column) const;

private:
    struct Finalize {
        void operator()(sqlite3_stmt* statement) const;
    };
    std::unique_ptr<sqlite3_stmt, Finalize> statement_;
};

// An SQLite database of strangers, opened without a write to it or to files beside it. What its
// schema could make SQLite run is refused: views, triggers, virtual tables and computed columns. A
// write-ahead log that a crash left behind is read.
class Db3Database {
public:
    // Throws Error{BadData} with the reason if it is not a database that can be read.
    explicit Db3Database(const std::filesystem::path& path);

    Db3Query query(std::string_view sql) const { return Db3Query(database_.get(), sql); }
    // Returns whether the file is shorter than it says; what is there can be read.
    bool is_cut() const { return is_cut_; }
    // Returns the size of the write-ahead log that is read too; 0 if there is none.
    std::int64_t log_bytes() const { return log_bytes_; }

private:
    struct Close {
        void operator()(sqlite3* database) const;
    };
    void limit();
    // Returns what in the schema no bag has; "" if there is nothing.
    std::string problem_of_schema() const;

    std::int64_t log_bytes_ = 0;
    bool is_cut_ = false;
    std::unique_ptr<sqlite3, Close> database_;
};

}  // namespace divemesh::recording
