// What a catalog in PostgreSQL survives.
#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <cstring>
#include <fstream>
#include <gmock/gmock.h>
#include <memory>
#include <net/if.h>
#include <sched.h>
#include <soci/soci.h>
#include <string>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <thread>

#include "schemas/file_descriptor.hpp"
#include "storage/catalog_url.hpp"
#include "storage/job_store.hpp"
#include "storage/queue_signal.hpp"
#include "storage/storable_text.hpp"
#include "tests/small_disk.hpp"
#include "tests/storage/store_fixture.hpp"

namespace divemesh::storage {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::Not;

// A server of the test's own, with a catalog in it.
class PostgresqlEngineTest : public testing::Test {
protected:
    void SetUp() override {
        if (!PostgresqlServer::is_installed()) GTEST_SKIP() << "PostgreSQL is not installed";
        server_ = std::make_unique<PostgresqlServer>();
        server_->run("CREATE DATABASE catalog");
        stores_ = std::make_unique<Stores>(server_->url("catalog"));
    }

    void restart(int signal) {
        server_->stop(signal);
        server_->start();
    }
    // Ends every connection to the catalog, as a failing network or an administrator does.
    void cut_connections() {
        server_->run(
            "SELECT pg_terminate_backend(pid, 10000) FROM pg_stat_activity"
            " WHERE datname = 'catalog'");
    }
    // With the addresses of both, the server that takes changes is used.
    void expect_other_server_is_taken() const {
        const PostgresqlServer primary;
        primary.run("CREATE DATABASE catalog");
        const std::string other = primary.url("");
        Stores stores(server_->url("catalog") + "," + other.substr(other.find("host=") + 5) +
                      "&target_session_attrs=read-write");
        stores.finished_upload();
        EXPECT_EQ(primary.run("SELECT COUNT(*) FROM uploads", "catalog"), "1");
    }
    std::string error_of(const std::function<void()>& act) {
        try {
            act();
        } catch (const Error& error) {
            return std::string(to_string(error.code())) + ": " + error.what();
        }
        return "no error";
    }

    std::unique_ptr<PostgresqlServer> server_;
    std::unique_ptr<Stores> stores_;
};

TEST_F(PostgresqlEngineTest, AnOrderlyRestartIsNotNoticedByTheNextCall) {
    const Job job = stores_->enqueue(stores_->ready_dive());
    restart(SIGINT);
    EXPECT_EQ(stores_->jobs_.get(job.id).state, JobState::Queued);
    restart(SIGINT);
    EXPECT_TRUE(stores_->jobs_.succeed(stores_->claim().lease, {}));
    EXPECT_EQ(stores_->jobs_.get(job.id).state, JobState::Succeeded);
}

TEST_F(PostgresqlEngineTest, ACrashOfTheServerLosesNothingThatACallHasReturned) {
    const Dive dive = stores_->ready_dive();
    std::vector<std::string> ids;
    for (int round = 0; round < 3; ++round) {
        for (int i = 0; i < 5; ++i) ids.push_back(stores_->enqueue(dive).id);
        restart(SIGQUIT);
    }
    for (const std::string& id : ids) EXPECT_EQ(stores_->jobs_.get(id).state, JobState::Queued);
}

TEST_F(PostgresqlEngineTest, WithoutAServerEveryCallSaysSoUntilItIsBack) {
    const Job job = stores_->enqueue(stores_->ready_dive());
    server_->stop(SIGINT);
    for (int i = 0; i < 20; ++i) {  // more calls than connections, so that none may be lost
        EXPECT_TRUE(throws_code(ErrorCode::Unavailable, [&] { stores_->jobs_.get(job.id); }));
        EXPECT_TRUE(throws_code(ErrorCode::Unavailable, [&] { stores_->jobs_.cancel(job.id); }));
    }
    EXPECT_THAT(error_of([&] { stores_->jobs_.get(job.id); }), HasSubstr("check that it runs"));
    server_->start();
    EXPECT_EQ(stores_->jobs_.cancel(job.id).state, JobState::Cancelled);
}

TEST_F(PostgresqlEngineTest, ATransactionWhoseConnectionIsCutLeavesNothing) {
    const auto newest = stores_->events_.newest_sequence();
    EXPECT_TRUE(throws_code(ErrorCode::Unavailable, [&] {
        stores_->catalog_.transaction([&](soci::session& session) {
            EventStore::append(session, {.subject = "job", .type = "job.state"});
            cut_connections();
            EventStore::append(session, {.subject = "job", .type = "job.state"});
        });
    }));
    EXPECT_EQ(stores_->events_.newest_sequence(), newest);
    stores_->finished_upload();
    EXPECT_GT(stores_->events_.newest_sequence(), newest);
}

TEST_F(PostgresqlEngineTest, AConnectionThatIsCutBeforeTheCommitIsNoSuccess) {
    EXPECT_TRUE(throws_code(ErrorCode::Unavailable, [&] {
        stores_->catalog_.transaction([&](soci::session& session) {
            session << "UPDATE event_sequence SET newest = 7";
            cut_connections();
        });
    }));
    EXPECT_EQ(stores_->events_.newest_sequence(), 0);
}

// As when code goes on after a statement that failed: PostgreSQL answers such a COMMIT with
// ROLLBACK.
TEST_F(PostgresqlEngineTest, ATransactionWithAFailedStatementIsNotTakenForCommitted) {
    EXPECT_THROW(stores_->catalog_.transaction([&](soci::session& session) {
        session << "UPDATE event_sequence SET newest = 7";
        EXPECT_THROW(session << "SELECT no_such_column FROM event_sequence", soci::soci_error);
    }),
                 soci::soci_error);
    EXPECT_EQ(stores_->events_.newest_sequence(), 0);
}

// A process that is stopped, or whose machine vanished, in the middle of a transaction.
TEST_F(PostgresqlEngineTest, AWriterThatHangsLosesItsTransactionAndTheOthersGoOn) {
    Catalog other(server_->url("catalog"));
    std::thread waiting;
    EXPECT_TRUE(throws_code(ErrorCode::Unavailable, [&] {
        stores_->catalog_.transaction([&](soci::session& session) {
            session << "SET idle_in_transaction_session_timeout = '300ms'";
            session << "UPDATE event_sequence SET newest = 7";
            waiting = std::thread([&] {
                other.transaction([](soci::session& theirs) {
                    theirs << "UPDATE event_sequence SET newest = newest + 1";
                });
            });
            std::this_thread::sleep_for(1s);
        });
    }));
    waiting.join();
    EXPECT_EQ(stores_->events_.newest_sequence(), 1);
}

TEST_F(PostgresqlEngineTest, AStandbyIsReadAndTakesChangesOnceItIsPromoted) {
    const Job job = stores_->enqueue(stores_->ready_dive());
    server_->stop(SIGINT);
    std::ofstream(server_->data() / "standby.signal");
    server_->start();

    EXPECT_EQ(stores_->jobs_.get(job.id).state, JobState::Queued);
    EXPECT_THAT(error_of([&] { stores_->jobs_.cancel(job.id); }), HasSubstr("standby"));
    EXPECT_TRUE(throws_code(ErrorCode::Unavailable, [&] { stores_->catalog_.require_writable(); }));
    EXPECT_EQ(Stores(server_->url("catalog")).jobs_.get(job.id).state, JobState::Queued);
    expect_other_server_is_taken();
    server_->run("SELECT pg_promote()");
    EXPECT_EQ(stores_->jobs_.cancel(job.id).state, JobState::Cancelled);
}

class PostgresqlFullDiskTest : public PostgresqlEngineTest {};

TEST_F(PostgresqlFullDiskTest, AFullDiskIsSaidAndReadFromAndWrittenAgainOnceThereIsSpace) {
    const SmallDisk disk(32);
    if (!disk.mounted()) GTEST_SKIP() << "only root can mount a small disk";
    PostgresqlServer::give(disk.path());
    server_->run("CREATE TABLESPACE small LOCATION '" + disk.path().string() + "'");
    server_->run("CREATE DATABASE full_catalog TABLESPACE small");
    {
        Stores stores(server_->url("full_catalog"));
        const Job job = stores.enqueue(stores.ready_dive());
        disk.fill();
        ErrorCode code = ErrorCode::Cancelled;
        const std::string log(100'000, 'x');
        const Lease lease = stores.claim().lease;
        for (int i = 0; i < 2000 && code == ErrorCode::Cancelled; ++i) {
            try {
                stores.catalog_.transaction([&](soci::session& session) {
                    std::string noise = log;
                    for (char& c : noise) c = static_cast<char>('a' + std::rand() % 26);
                    EventStore::append(session, {.subject = job.id, .type = noise});
                });
            } catch (const Error& error) {
                code = error.code();
            }
        }
        EXPECT_EQ(code, ErrorCode::OutOfSpace);
        EXPECT_EQ(stores.jobs_.get(job.id).state, JobState::Running);
        std::filesystem::remove(disk.path() / "filler");
        EXPECT_TRUE(stores.jobs_.succeed(lease, {}));
    }
    server_->run("DROP DATABASE full_catalog WITH (FORCE)");
}

// Switches the loopback of this process's own network on or off.
void set_loopback(bool is_up) {
    const FileDescriptor socket(::socket(AF_INET, SOCK_DGRAM, 0));
    ifreq request{};
    std::strcpy(request.ifr_name, "lo");
    request.ifr_flags = static_cast<short>(is_up ? IFF_UP | IFF_RUNNING : 0);
    if (ioctl(socket.get(), SIOCSIFFLAGS, &request) != 0) throw std::runtime_error("loopback");
}

// Returns what went wrong; "" if all is well.
std::string lose_the_network() {
    using Clock = std::chrono::steady_clock;
    set_loopback(true);
    PostgresqlServer server({"fsync=off", "listen_addresses=127.0.0.1"});
    server.run("CREATE DATABASE catalog");
    Stores stores("postgresql://postgres@127.0.0.1/catalog");
    const Job job = stores.enqueue(stores.ready_dive());
    set_loopback(false);  // what is sent now arrives nowhere, and nobody says so
    const auto began = Clock::now();
    if (!throws_code(ErrorCode::Unavailable, [&] { stores.jobs_.get(job.id); }))
        return "a lost network is not noticed";
    if (Clock::now() - began > 30s) return "a lost network is noticed too late";
    set_loopback(true);
    return stores.jobs_.get(job.id).state == JobState::Queued ? "" : "the job is lost";
}

TEST(PostgresqlLostNetworkTest, AConnectionThatNobodyAnswersIsGivenUpAndReplaced) {
    if (!PostgresqlServer::is_installed()) GTEST_SKIP() << "PostgreSQL is not installed";
    const pid_t child = fork();
    if (child == 0) {
        if (unshare(CLONE_NEWNET) != 0) _exit(2);
        try {
            const std::string fault = lose_the_network();
            fprintf(stderr, "%s\n", fault.c_str());
            _exit(fault.empty() ? 0 : 1);
        } catch (const std::exception& error) {
            fprintf(stderr, "%s\n", error.what());
            _exit(1);
        }
    }
    int status = 0;
    waitpid(child, &status, 0);
    ASSERT_TRUE(WIFEXITED(status));
    if (WEXITSTATUS(status) == 2) GTEST_SKIP() << "only root has a network of its own";
    EXPECT_EQ(WEXITSTATUS(status), 0);
}

TEST_F(PostgresqlEngineTest, MakesNoCatalogOfAnotherDatabaseAndNoDatabase) {
    server_->run("CREATE DATABASE photos");
    server_->run("CREATE TABLE photos (id INTEGER)", "photos");
    const std::string url = server_->url("photos");
    EXPECT_TRUE(throws_code(ErrorCode::Unavailable, [&] { Catalog{url, Opening::ExistingOnly}; }));
    EXPECT_EQ(server_->run("SELECT COUNT(*) FROM pg_tables WHERE schemaname = 'public'", "photos"),
              "1");
    EXPECT_THAT(error_of([&] { Catalog{server_->url("nowhere")}; }), HasSubstr("does not exist"));
    EXPECT_FALSE(server_->has_database("nowhere"));
}

TEST_F(PostgresqlEngineTest, RefusesADatabaseThatDoesNotHoldUtf8) {
    server_->run(
        "CREATE DATABASE latin ENCODING 'LATIN1' LOCALE 'C' TEMPLATE template0"
        " LOCALE_PROVIDER libc");
    EXPECT_TRUE(throws_code(ErrorCode::InvalidArgument, [&] { Catalog{server_->url("latin")}; }));
}

TEST_F(PostgresqlEngineTest, GivesUpNoDurabilityThatTheServerIsConfiguredToGiveUp) {
    const auto setting = [&] {
        std::string value;
        Catalog(server_->url("catalog")).read([&](soci::session& session) {
            session << "SHOW synchronous_commit", soci::into(value);
        });
        return value;
    };
    EXPECT_EQ(setting(), "on");
    server_->run("ALTER DATABASE catalog SET synchronous_commit = off");
    EXPECT_EQ(setting(), "on");
    server_->run("ALTER DATABASE catalog SET synchronous_commit = remote_apply");
    EXPECT_EQ(setting(), "remote_apply");
}

TEST_F(PostgresqlEngineTest, ANonBlockingReadNeverWaitsForIt) {
    Catalog read_nonblocking = stores_->catalog_.read_nonblocking();
    EXPECT_TRUE(
        throws_code(ErrorCode::Unavailable, [&] { read_nonblocking.read([](soci::session&) {}); }));
}

TEST_F(PostgresqlEngineTest, AWaitingWorkerHearsOfAJobAtOnceAlsoAfterItsConnectionWasCut) {
    const auto signal = listen_to_queue(server_->url("catalog"));
    const Dive dive = stores_->ready_dive();
    const auto seconds_until_heard = [&](const std::function<void()>& act) {
        std::jthread soon([&] {
            std::this_thread::sleep_for(200ms);
            act();
        });
        const auto began = std::chrono::steady_clock::now();
        signal->wait(20s);
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
    };
    signal->wait(20s);  // begins to listen
    for (int i = 0; i < 2; ++i) {
        const double heard_s = seconds_until_heard([&] { stores_->enqueue(dive); });
        EXPECT_GT(heard_s, 0.15);
        EXPECT_LT(heard_s, 10.0);
        EXPECT_LT(seconds_until_heard([&] { stores_->jobs_.release(stores_->claim().lease); }),
                  10.0);
        cut_connections();
        const auto num_listening = [&] {
            return server_->run("SELECT COUNT(*) FROM pg_stat_activity WHERE query LIKE 'LISTEN%'");
        };
        while (num_listening() == "0") signal->wait(10ms);
    }
    const auto began = std::chrono::steady_clock::now();
    signal->wait(300ms);  // nothing was queued
    EXPECT_GE(std::chrono::steady_clock::now() - began, 300ms);
    EXPECT_EQ(listen_to_queue("sqlite:///catalog.db"), nullptr);
}

TEST_F(PostgresqlEngineTest, IsBackedUpByItsOwnTools) {
    const TemporaryFolder folder;
    EXPECT_THAT(error_of([&] { stores_->catalog_.copy_to(folder / "copy"); }),
                HasSubstr("pg_dump"));
    stores_->catalog_.checkpoint();
}

TEST(PostgresqlUrlTest, NoMessageShowsAPassword) {
    for (const char* url : {"postgresql://diver:secret@127.0.0.1:1/catalog",
                            "postgresql://diver:secret@127.0.0.1:none/catalog",
                            "postgresql://127.0.0.1:1/catalog?user=diver&password=secret",
                            "postgresql://diver:secret@/catalog?no_such_option=1",
                            "postgres://diver:sec%zzret@127.0.0.1:1/catalog",
                            "postgresqls://diver:secret@127.0.0.1:1/catalog"}) {
        try {
            Catalog catalog(url);
            ADD_FAILURE() << url << " was opened";
        } catch (const Error& error) {
            EXPECT_THAT(error.what(), Not(HasSubstr("sec"))) << error.what();
        }
        EXPECT_THAT(without_password(url), Not(HasSubstr("sec")));
    }
    EXPECT_EQ(without_password("postgresql://diver:p@ss:w/o@host/name?sslmode=require"),
              "postgresql://diver:***@host/name?sslmode=require");
    EXPECT_EQ(without_password("postgresql:///name?password=a&user=b"),
              "postgresql:///name?password=***&user=b");
    EXPECT_EQ(without_password("sqlite:///a:b@c/catalog.db"), "sqlite:///a:b@c/catalog.db");
}

TEST(PostgresqlTextTest, OnlyWhatPostgresqlRefusesIsReplaced) {
    for (const char* text : {"", "plain\n\t", "ü 水 \xF0\x9F\x90\x9F"})
        EXPECT_EQ(storable_text(text), std::nullopt) << text;
    EXPECT_EQ(storable_text("a\xff\xfe"), "a\uFFFD\uFFFD");
    EXPECT_EQ(storable_text("\xE6\xB0"), "\uFFFD");  // cut in the middle of a sign
    EXPECT_EQ(storable_text(std::string("a\0b", 3)), "a\uFFFDb");
    EXPECT_EQ(storable_text("\xED\xA0\x80"), "\uFFFD\uFFFD\uFFFD");  // half of a surrogate pair
}

}  // namespace
}  // namespace divemesh::storage
