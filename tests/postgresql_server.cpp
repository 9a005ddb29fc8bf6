#include "tests/postgresql_server.hpp"

#include <algorithm>
#include <chrono>
#include <csignal>
#include <fcntl.h>
#include <grp.h>
#include <libpq-fe.h>
#include <memory>
#include <pwd.h>
#include <stdexcept>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>

namespace divemesh {
namespace {

namespace fs = std::filesystem;

constexpr const char* kPrograms = "/usr/lib/postgresql";  // a folder for each version

// Returns the folder of the newest version's programs; "" if there is none.
fs::path programs() {
    std::vector<fs::path> found;
    std::error_code missing;
    for (const auto& version : fs::directory_iterator(kPrograms, missing))
        if (fs::exists(version.path() / "bin/postgres")) found.push_back(version.path() / "bin");
    return found.empty() ? fs::path() : *std::max_element(found.begin(), found.end());
}

// Returns the user that the server runs as; null: the one of this process.
const passwd* other_user() { return geteuid() == 0 ? getpwnam("postgres") : nullptr; }

void throw_message(PGconn* connection) { throw std::runtime_error(PQerrorMessage(connection)); }

}  // namespace

const std::vector<std::string> PostgresqlServer::kFast = {"fsync=off", "full_page_writes=off"};

bool PostgresqlServer::is_installed() {
    return !programs().empty() && (geteuid() != 0 || other_user() != nullptr);
}

void PostgresqlServer::give(const fs::path& folder) {
    const passwd* user = other_user();
    if (user != nullptr && chown(folder.c_str(), user->pw_uid, user->pw_gid) != 0)
        throw std::runtime_error("chown " + folder.string());
}

PostgresqlServer::PostgresqlServer(const std::vector<std::string>& settings) : settings_(settings) {
    give(folder_.path());
    const pid_t made = start_program({programs() / "initdb",
                                      "--pgdata",
                                      data(),
                                      "--auth=trust",
                                      "--username=postgres",
                                      "--encoding=UTF8",
                                      "--locale=C",
                                      "--locale-provider=icu",
                                      "--icu-locale=en",
                                      "--no-sync"});
    int status = 0;
    waitpid(made, &status, 0);
    if (status != 0) throw std::runtime_error("initdb fails: " + (folder_ / "log").string());
    start();
}

PostgresqlServer::~PostgresqlServer() { stop(SIGQUIT); }

std::string PostgresqlServer::url(const std::string& database) const {
    return "postgresql://postgres@/" + database + "?host=" + folder_.path().string();
}

std::string PostgresqlServer::run(const std::string& sql, const std::string& database) const {
    const std::unique_ptr<PGconn, decltype(&PQfinish)> connection(
        PQconnectdb(url(database).c_str()), PQfinish);
    if (PQstatus(connection.get()) != CONNECTION_OK) throw_message(connection.get());
    const std::unique_ptr<PGresult, decltype(&PQclear)> result(
        PQexec(connection.get(), sql.c_str()), PQclear);
    const ExecStatusType status = PQresultStatus(result.get());
    if (status != PGRES_COMMAND_OK && status != PGRES_TUPLES_OK) throw_message(connection.get());
    return PQntuples(result.get()) > 0 ? PQgetvalue(result.get(), 0, 0) : "";
}

bool PostgresqlServer::has_database(const std::string& name) const {
    return run("SELECT COUNT(*) FROM pg_database WHERE datname = '" + name + "'") != "0";
}

void PostgresqlServer::start() {
    std::vector<std::string> command = {programs() / "postgres",
                                        "-D",
                                        data(),
                                        "-k",
                                        folder_.path(),
                                        "-h",
                                        "",
                                        "-c",
                                        "max_connections=300"};
    for (const std::string& setting : settings_) {
        command.emplace_back("-c");
        command.push_back(setting);
    }
    pid_ = start_program(command);
    const std::string address = url("postgres");
    const auto give_up = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (PQping(address.c_str()) != PQPING_OK) {
        if (waitpid(pid_, nullptr, WNOHANG) != 0 || std::chrono::steady_clock::now() > give_up)
            throw std::runtime_error("PostgreSQL does not start: " + (folder_ / "log").string());
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
}

void PostgresqlServer::stop(int signal) {
    if (pid_ < 0) return;
    kill(pid_, signal);
    waitpid(pid_, nullptr, 0);
    pid_ = -1;
}

// The child dies with this thread, also if it is killed.
pid_t PostgresqlServer::start_program(const std::vector<std::string>& command) const {
    std::vector<char*> arguments;
    for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);
    const passwd* user = other_user();
    const std::string log = folder_ / "log";
    const pid_t child = fork();
    if (child != 0) return child;
    if (user != nullptr &&
        (setgroups(0, nullptr) != 0 || setgid(user->pw_gid) != 0 || setuid(user->pw_uid) != 0))
        _exit(126);
    prctl(PR_SET_PDEATHSIG, SIGQUIT);
    const int file = open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND, 0600);
    dup2(file, STDOUT_FILENO);
    dup2(file, STDERR_FILENO);
    if (chdir("/") == 0) execv(arguments[0], arguments.data());
    _exit(127);
}

}  // namespace divemesh
