// The service with its catalog in PostgreSQL.
#include <gtest/gtest.h>

#include <csignal>
#include <gmock/gmock.h>
#include <memory>

#include "tests/end_to_end/service.hpp"
#include "tests/postgresql_server.hpp"

namespace divemesh {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;
using testing::Not;

class PostgresqlServiceTest : public testing::Test {
protected:
    void SetUp() override {
        if (!PostgresqlServer::is_installed()) GTEST_SKIP() << "PostgreSQL is not installed";
        database_ = std::make_unique<PostgresqlServer>();
        database_->run("CREATE DATABASE catalog");
        std::string url = database_->url("catalog");
        url.insert(url.find('@'), ":hidden");  // a password, which this database does not ask for
        service_ = std::make_unique<Service>(url);
    }

    std::unique_ptr<PostgresqlServer> database_;
    std::unique_ptr<Service> service_;
};

TEST_F(PostgresqlServiceTest, ADiveBecomesAMeshAlthoughTheDatabaseCrashesMeanwhile) {
    service_->start_server(1);
    const Outcome sent = service_->run({"upload", small_dive().string(), "--json"}, 120s);
    ASSERT_EQ(sent.exit_code, 0) << sent.err;
    service_->wait_for_reconstruction("running", 120s);
    EXPECT_THAT(service_->processes(), Not(testing::Contains(HasSubstr("hidden"))));

    database_->stop(SIGQUIT);
    EXPECT_NE(service_->run({"jobs", "--json"}).exit_code, 0);
    database_->start();

    const auto job = service_->wait_for_reconstruction("succeeded", 300s);
    const Outcome got = service_->run(
        {"download", job.at("id").get<std::string>(), "--out", (*service_ / "result").string()});
    EXPECT_EQ(got.exit_code, 0) << got.err;
    EXPECT_TRUE(std::filesystem::exists(*service_ / "result/mesh.ply"));
    EXPECT_FALSE(std::filesystem::exists(*service_ / "data/catalog.db"));
    EXPECT_THAT(service_->server().stderr_text(), Not(HasSubstr("hidden")));
}

TEST_F(PostgresqlServiceTest, IsNotBackedUpOrRestoredAsIfItWereAFile) {
    service_->start_server(0);
    const std::string file = (*service_ / "backup.tar").string();
    const std::string data = (*service_ / "data").string();
    const Outcome backup = service_->run({"backup", "--data", data, file});
    EXPECT_EQ(backup.exit_code, 1);
    EXPECT_THAT(backup.err, HasSubstr("pg_dump"));
    const Outcome restore = service_->run({"restore", "--data", data, file});
    EXPECT_EQ(restore.exit_code, 1);
    EXPECT_THAT(restore.err, HasSubstr("pg_restore"));
}

}  // namespace
}  // namespace divemesh
