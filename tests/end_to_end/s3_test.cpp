#include <gtest/gtest.h>

#include <algorithm>
#include <csignal>
#include <filesystem>

#include "storage/s3_client.hpp"
#include "tests/end_to_end/service.hpp"
#include "tests/storage/faulty_gateway.hpp"
#include "tests/storage/s3_server.hpp"

namespace divemesh {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;
using storage::FaultyGateway;
using storage::S3Server;

// A service whose blobs are in an object store behind a gateway.
class S3Test : public testing::Test {
protected:
    void SetUp() override {
        store_ = S3Server::start_s3rver();
        if (!store_) GTEST_SKIP() << "run npm ci in tests/end_to_end/js first";
        gateway_ = std::make_unique<FaultyGateway>(store_->port());
        service_ = std::make_unique<Service>(url("service"), keys());
    }

    std::string url(const std::string& prefix) const {
        return store_->url(prefix, gateway_->port());
    }
    Process::Environment keys() const {
        return {{"AWS_ACCESS_KEY_ID", store_->credentials().access_key},
                {"AWS_SECRET_ACCESS_KEY", store_->credentials().secret_key}};
    }
    std::ptrdiff_t num_requests(const std::string& method, const std::string& part) const {
        const auto lines = gateway_->requests();
        return std::count_if(lines.begin(), lines.end(), [&](const std::string& line) {
            return line.starts_with(method + ' ') && line.find(part) != std::string::npos;
        });
    }
    std::int64_t num_staged_bytes() const {
        std::int64_t size = 0;
        for (const auto& entry : fs::recursive_directory_iterator(*service_ / "data/staged"))
            if (entry.is_regular_file()) size += static_cast<std::int64_t>(entry.file_size());
        return size;
    }

    std::unique_ptr<S3Server> store_;
    std::unique_ptr<FaultyGateway> gateway_;
    std::unique_ptr<Service> service_;
};

// The worker knows the catalog and the object store, no folder of the server.
TEST_F(S3Test, ADiveGoesThroughTheObjectStore) {
    service_->start_server(0);
    const Process worker = service_->start_worker();
    const fs::path result = *service_ / "result";
    const Outcome outcome = service_->run(
        {"upload", small_dive().string(), "--wait", "--download", result.string()}, 300s);

    ASSERT_EQ(outcome.exit_code, 0) << outcome.out << outcome.err << worker.stdout_text()
                                    << worker.stderr_text() << service_->server().stderr_text();
    EXPECT_GT(fs::file_size(result / "mesh.ply"), 1000U);
    EXPECT_FALSE(fs::exists(*service_ / "data/blobs"));
    EXPECT_EQ(num_staged_bytes(), 0);
    EXPECT_EQ(num_requests("GET", "/archive"), 2) << "the intake and the reconstruction";
    const auto archive = service_->dives().at(0).at("archive_bytes").get<std::int64_t>();
    std::int64_t results = 0;
    for (const auto& entry : fs::recursive_directory_iterator(result))
        if (entry.is_regular_file()) results += static_cast<std::int64_t>(entry.file_size());
    EXPECT_LT(static_cast<double>(gateway_->num_bytes_sent()),
              1.02 * static_cast<double>(archive + 2 * results));
}

TEST_F(S3Test, AServerThatIsKilledWhileItSendsADiveMakesItLater) {
    gateway_->make_fail(
        {.method = "PUT", .target = "/archive", .trouble = storage::Trouble::Silence});
    service_->start_server(1);
    Process upload = service_->start({"upload", small_dive().string(), "--wait"});
    ASSERT_TRUE(wait_until(60s, [&] { return num_requests("PUT", "/archive") == 1; }))
        << upload.stderr_text();
    service_->kill_server();
    EXPECT_GT(num_staged_bytes(), 0);

    service_->start_server(1);
    EXPECT_EQ(upload.wait(180s), 0) << upload.stderr_text() << service_->server().stderr_text();
    EXPECT_EQ(num_staged_bytes(), 0);
    EXPECT_EQ(service_->dives().size(), 1U);
}

TEST_F(S3Test, AServerThatSendsADiveEndsWhenItIsTold) {
    gateway_->make_fail({.method = "PUT",
                         .target = "/archive",
                         .answer = storage::refusal(503, "SlowDown"),
                         .num_times = 100'000});
    service_->start_server(0);
    Process upload = service_->start({"upload", small_dive().string(), "--no-job"});
    ASSERT_TRUE(wait_until(60s, [&] { return num_requests("PUT", "/archive") >= 1; }))
        << upload.stderr_text();
    service_->server().send(SIGTERM);
    EXPECT_EQ(service_->server().wait(20s), 0);
    EXPECT_GT(num_staged_bytes(), 0);
}

TEST_F(S3Test, ABackupIsRestoredIntoAnotherPlaceOfTheObjectStore) {
    service_->start_server(0);
    const Outcome upload = service_->run({"upload", small_dive().string(), "--no-job"}, 120s);
    ASSERT_EQ(upload.exit_code, 0) << upload.err;
    const std::string backup = (*service_ / "backup.tar").string();
    const std::string data = (*service_ / "data").string();
    const std::string restored = (*service_ / "restored").string();

    const Outcome made =
        service_->run({"backup", "--data", data, "--blobs", url("service"), backup});
    ASSERT_EQ(made.exit_code, 0) << made.err;
    const Outcome back =
        service_->run({"restore", "--data", restored, "--blobs", url("restored"), backup});
    ASSERT_EQ(back.exit_code, 0) << back.err;

    storage::S3Client client(storage::parse_s3_url(url("")), store_->credentials());
    EXPECT_EQ(client.list("restored/blobs/dives/", false).names,
              client.list("service/blobs/dives/", false).names);
    EXPECT_EQ(client.list("restored/blobs/dives/", false).names.size(), 1U);
    EXPECT_TRUE(client.get_small("restored/data-id", 100));
}

TEST_F(S3Test, AWrongBucketIsNamedAtTheStart) {
    const std::string wrong =
        "s3://nowhere?endpoint=http://127.0.0.1:" + std::to_string(gateway_->port());
    const Outcome outcome = service_->run({"serve",
                                           "--data",
                                           (*service_ / "data").string(),
                                           "--listen",
                                           "127.0.0.1:0",
                                           "--blobs",
                                           wrong});
    EXPECT_NE(outcome.exit_code, 0);
    EXPECT_NE(outcome.err.find("there is no such bucket: create it"), std::string::npos)
        << outcome.err;
}

}  // namespace
}  // namespace divemesh
