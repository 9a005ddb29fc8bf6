#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <gmock/gmock.h>

#include "api/client/rest_client.hpp"
#include "tests/end_to_end/service.hpp"
#include "tests/paths.hpp"

namespace divemesh {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

class ReconstructionTest : public testing::Test {
protected:
    std::string upload() {
        const Outcome outcome = service.run({"upload", small_dive().string(), "--json"}, 120s);
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        return nlohmann::json::parse(outcome.out).at("job").get<std::string>();
    }

    void expect_no_process_left() {
        EXPECT_TRUE(wait_until(10s, [&] { return service.processes().empty(); }))
            << testing::PrintToString(service.processes());
    }

    Service service;
};

TEST_F(ReconstructionTest, TurnsAnUploadedDiveIntoAMeasuredMesh) {
    service.start_server(1);
    const fs::path result = service / "result";
    const Outcome outcome = service.run(
        {"upload", small_dive().string(), "--wait", "--download", result.string()}, 300s);
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    for (const char* name : {"trajectory.tum",
                             "trajectory_causal.tum",
                             "trajectory_covariance.csv",
                             "cloud.ply",
                             "mesh.ply",
                             "mesh.glb",
                             "mosaic.tif",
                             "heights.tif",
                             "heights_sigma.tif",
                             "mosaic.png",
                             "mosaic.json",
                             "keyframes.json",
                             "metrics.json",
                             "certificate.json",
                             "report.html"})
        EXPECT_TRUE(fs::exists(result / name)) << name;
    const auto metrics = nlohmann::json::parse(read_text(result / "metrics.json"));
    EXPECT_LT(metrics.at("trajectory").at("final").at("ate_rmse_m").get<double>(), 0.05);
    EXPECT_NE(outcome.err.find("trajectory error, RMSE"), std::string::npos) << outcome.err;
}

TEST_F(ReconstructionTest, DoesNotTrackAgainForAnotherVoxelSize) {
    service.start_server(1);
    upload();
    const auto first = service.wait_for_reconstruction("succeeded", 180s);
    api::client::RestClient rest(
        {api::client::parse_server_url(service.address()), service.token()});

    const std::string second =
        rest.post("/api/v1/dives/" + first.at("dive_id").get<std::string>() + "/jobs",
                  {{"options", {{"voxel_m", 0.03}}}})
            .at("id");
    ASSERT_TRUE(wait_until(180s, [&] { return service.job(second).at("state") == "succeeded"; }));

    const auto cached = [&](const nlohmann::json& job) {
        std::vector<std::string> names;
        for (const auto& stage : job.at("stages"))
            if (stage.at("from_cache")) names.push_back(stage.at("name"));
        return names;
    };
    EXPECT_THAT(cached(first), testing::IsEmpty());
    EXPECT_THAT(cached(service.job(second)), testing::ElementsAre("track", "optimise"));
}

TEST_F(ReconstructionTest, GivesFilesThatForeignValidatorsAccept) {
    const fs::path checker = source_directory() / "tests/end_to_end/js";
    if (!fs::exists(checker / "node_modules"))
        GTEST_SKIP() << "run npm ci in tests/end_to_end/js first";
    const Outcome made = service.run(
        {"reconstruct", small_dive().string(), "--out", (service / "result").string()}, 300s);
    ASSERT_EQ(made.exit_code, 0) << made.err;
    const std::string result = (service / "result").string();
    const Outcome exported = service.run({"export", result, "--format", "3dtiles,mcap"}, 60s);
    ASSERT_EQ(exported.exit_code, 0) << exported.err;
    const std::string schema = (source_directory() / "schemas/metrics.schema.json").string();
    for (const std::vector<std::string>& check :
         {std::vector<std::string>{"check_outputs.mjs", result, schema},
          {"check_tiles.mjs", result + "/tiles", "textured"},
          {"check_mcap.mjs", result + "/reconstruction.mcap"}}) {
        std::vector<std::string> command = {"/usr/bin/env", "node", (checker / check[0]).string()};
        command.insert(command.end(), check.begin() + 1, check.end());
        Process node(command, service / ".");
        EXPECT_EQ(node.wait(120s), 0) << node.stdout_text() << node.stderr_text();
    }
}

TEST_F(ReconstructionTest, GivesTheSameBytesWithOneThreadAndWithTwo) {
    const auto reconstruct = [&](const std::string& num_threads) {
        const fs::path out = service / ("threads-" + num_threads);
        const Outcome made = service.run(
            {"reconstruct", small_dive().string(), "--out", out.string(), "--threads", num_threads},
            300s);
        EXPECT_EQ(made.exit_code, 0) << made.err;
        return out;
    };
    const fs::path one = reconstruct("1");
    const fs::path two = reconstruct("2");
    std::vector<std::string> names;
    for (const auto& entry : fs::recursive_directory_iterator(one))
        if (entry.is_regular_file()) names.push_back(fs::relative(entry.path(), one).string());
    EXPECT_THAT(names, testing::IsSupersetOf({"mesh.glb", "mesh.ply", "cloud.ply", "mosaic.png"}));
    for (const std::string& name : names) {
        if (name == "metrics.json" || name == "report.html") continue;  // they hold the times taken
        EXPECT_TRUE(read_text(one / name) == read_text(two / name)) << name;
    }
    const auto without_times = [](const fs::path& out) {
        auto metrics = nlohmann::json::parse(read_text(out / "metrics.json"));
        metrics.erase("speed");
        metrics.at("options").erase("num_threads");
        return metrics;
    };
    EXPECT_EQ(without_times(one), without_times(two));
}

TEST_F(ReconstructionTest, RunsAgainWhenItsWorkerIsKilled) {
    service.start_server(0);
    Process doomed = service.start_worker();
    const std::string job = upload();
    service.wait_for_reconstruction("running", 60s);
    doomed.kill();
    Process second = service.start_worker();
    EXPECT_TRUE(wait_until(30s, [&] { return service.job(job).at("num_attempts") == 2; }));
    const auto done = service.wait_for_reconstruction("succeeded", 180s);
    EXPECT_EQ(done.at("id"), job);
    EXPECT_EQ(done.at("num_attempts"), 2);
}

TEST_F(ReconstructionTest, IsNotDisturbedWhenTheServerIsKilled) {
    service.start_server(0);
    const Process worker = service.start_worker();
    upload();
    service.wait_for_reconstruction("running", 60s);
    service.kill_server();
    service.start_server(0);
    const auto done = service.wait_for_reconstruction("succeeded", 180s);
    EXPECT_EQ(done.at("num_attempts"), 1);
}

TEST_F(ReconstructionTest, EndsWithItsServersWorkersWhenThatIsKilledAndIsDoneByTheNextOne) {
    service.start_server(1);
    upload();
    service.wait_for_reconstruction("running", 60s);
    service.kill_server();
    expect_no_process_left();
    service.start_server(1);
    service.wait_for_reconstruction("succeeded", 240s);
}

TEST_F(ReconstructionTest, StopsWhenItIsCancelledAndRunsWhenItIsAskedForAgain) {
    service.start_server(1);
    const std::string job = upload();
    service.wait_for_reconstruction("running", 60s);
    EXPECT_EQ(service.run({"cancel", job}).exit_code, 0);
    service.wait_for_reconstruction("cancelled", 15s);
    EXPECT_EQ(service.run({"cancel", job}).exit_code, 1) << "it is finished";
    EXPECT_EQ(service.run({"retry", job}).exit_code, 0);
    service.wait_for_reconstruction("succeeded", 180s);
}

TEST_F(ReconstructionTest, LeavesNothingBehindWhenTheServerIsAskedToStop) {
    service.start_server(1);
    upload();
    service.wait_for_reconstruction("running", 60s);
    service.server().send(SIGTERM);
    EXPECT_EQ(service.server().wait(20s), 0) << service.server().stderr_text();
    expect_no_process_left();
}

}  // namespace
}  // namespace divemesh
