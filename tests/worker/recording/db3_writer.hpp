#pragma once

#include <cstdint>
#include <filesystem>
#include <sqlite3.h>
#include <stdexcept>
#include <string>

namespace divemesh::recording {

// Writes a file of a ROS 2 bag by SQLite, with the tables that rosbag2_storage_sqlite3 makes in the
// versions 1 to 4 of its schema.
class Db3Writer {
public:
    explicit Db3Writer(const std::filesystem::path& path, int version = 4, int page_bytes = 4096) {
        if (sqlite3_open(path.c_str(), &database_) != SQLITE_OK) throw std::runtime_error("open");
        run("PRAGMA page_size = " + std::to_string(page_bytes));
        run("PRAGMA synchronous = OFF");
        const std::string qos = version >= 2 ? ", offered_qos_profiles TEXT NOT NULL" : "";
        const std::string hash = version >= 4 ? ", type_description_hash TEXT NOT NULL" : "";
        if (version >= 3) {
            run("CREATE TABLE schema(schema_version INTEGER PRIMARY KEY, ros_distro TEXT NOT "
                "NULL)");
            run("CREATE TABLE metadata(id INTEGER PRIMARY KEY, metadata_version INTEGER NOT NULL, "
                "metadata TEXT NOT NULL)");
        }
        run("CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT NOT NULL, type TEXT NOT NULL, "
            "serialization_format TEXT NOT NULL" +
            qos + hash + ")");
        if (version >= 4)
            run("CREATE TABLE message_definitions(id INTEGER PRIMARY KEY, topic_type TEXT NOT "
                "NULL, encoding TEXT NOT NULL, encoded_message_definition TEXT NOT NULL, "
                "type_description_hash TEXT NOT NULL)");
        run("CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER NOT NULL, timestamp "
            "INTEGER NOT NULL, data BLOB NOT NULL)");
        run("CREATE INDEX timestamp_idx ON messages (timestamp ASC)");
        more_columns_ = std::string(version >= 2 ? ", ''" : "") + (version >= 4 ? ", ''" : "");
        run("BEGIN");
    }
    ~Db3Writer() { finish(); }
    Db3Writer(const Db3Writer&) = delete;
    Db3Writer& operator=(const Db3Writer&) = delete;

    void add_channel(int number, const std::string& topic, const std::string& type) {
        run("INSERT INTO topics VALUES (" + std::to_string(number) + ", '" + topic + "', '" + type +
            "', 'cdr'" + more_columns_ + ")");
    }
    void add_message(int channel, std::int64_t time_ns, const std::string& bytes) {
        sqlite3_stmt* statement = nullptr;
        sqlite3_prepare_v2(database_,
                           "INSERT INTO messages (topic_id, timestamp, data) VALUES (?, ?, ?)",
                           -1,
                           &statement,
                           nullptr);
        sqlite3_bind_int(statement, 1, channel);
        sqlite3_bind_int64(statement, 2, time_ns);
        sqlite3_bind_blob(
            statement, 3, bytes.data(), static_cast<int>(bytes.size()), SQLITE_STATIC);
        sqlite3_step(statement);
        sqlite3_finalize(statement);
    }
    void run(const std::string& sql) {
        if (sqlite3_exec(database_, sql.c_str(), nullptr, nullptr, nullptr) != SQLITE_OK)
            throw std::runtime_error(sql + ": " + sqlite3_errmsg(database_));
    }
    void finish() {
        if (database_ == nullptr) return;
        sqlite3_exec(database_, "COMMIT", nullptr, nullptr, nullptr);
        sqlite3_close(database_);
        database_ = nullptr;
    }

private:
    sqlite3* database_ = nullptr;
    std::string more_columns_;
};

}  // namespace divemesh::recording
