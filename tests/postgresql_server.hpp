#pragma once

#include <filesystem>
#include <string>
#include <sys/types.h>
#include <vector>

#include "tests/temporary_folder.hpp"

namespace divemesh {

// A PostgreSQL server of this process, on a Unix socket in a temporary folder. It ends with this
// process. Run by root it runs as the user postgres, because it refuses root. It sorts text in
// another order than bytes unless it is told to.
class PostgresqlServer {
public:
    static bool is_installed();

    // `settings` are those of postgresql.conf: "fsync=off".
    explicit PostgresqlServer(const std::vector<std::string>& settings = kFast);
    ~PostgresqlServer();
    PostgresqlServer(const PostgresqlServer&) = delete;
    PostgresqlServer& operator=(const PostgresqlServer&) = delete;

    std::string url(const std::string& database) const;
    // Runs SQL outside of a transaction, and returns its first value; "" without one. Throws
    // std::runtime_error with PostgreSQL's message.
    std::string run(const std::string& sql, const std::string& database = "postgres") const;
    bool has_database(const std::string& name) const;

    void start();           // waits until it answers
    void stop(int signal);  // SIGINT: an orderly end, SIGQUIT: as a crash, SIGKILL: a crash
    // Gives a folder to the user that the server runs as.
    static void give(const std::filesystem::path& folder);
    std::filesystem::path data() const { return folder_ / "data"; }

    // For servers whose data need not survive the loss of power.
    static const std::vector<std::string> kFast;

private:
    pid_t start_program(const std::vector<std::string>& command) const;

    TemporaryFolder folder_;
    std::vector<std::string> settings_;
    pid_t pid_ = -1;
};

}  // namespace divemesh
