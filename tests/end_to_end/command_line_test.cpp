#include <gtest/gtest.h>

#include <csignal>
#include <fstream>
#include <iterator>

#include "storage/event_store.hpp"
#include "tests/end_to_end/service.hpp"
#include "tests/paths.hpp"

namespace divemesh {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

class CommandLineTest : public testing::Test {
protected:
    Outcome run(std::vector<std::string> arguments,
                Process::Environment environment = {},
                std::chrono::seconds timeout = 120s) {
        environment.emplace("XDG_CONFIG_HOME", folder.path().string());
        arguments.insert(arguments.begin(), divemesh_program().string());
        Process process(arguments, folder.path(), environment);
        const auto exit_code = process.wait(timeout);
        return {exit_code.value_or(-1), process.stdout_text(), process.stderr_text()};
    }

    TemporaryFolder folder;
};

TEST_F(CommandLineTest, HelpsWithEverySubCommand) {
    for (const std::string command :
         {"serve",  "worker", "token",    "upload",   "dives",     "jobs",        "download",
          "cancel", "retry",  "queue",    "workers",  "schedules", "reconstruct", "evaluate",
          "import", "report", "simulate", "validate", "backup",    "restore",     "demo"}) {
        const Outcome outcome = run({command, "--help"});
        EXPECT_EQ(outcome.exit_code, 0) << command;
        EXPECT_NE(outcome.out.find("Usage: divemesh " + command), std::string::npos) << outcome.out;
    }
    EXPECT_EQ(run({"--help"}).out.find("attempt"), std::string::npos);
}

TEST_F(CommandLineTest, EndsWithTwoWhenItIsUsedWrongly) {
    EXPECT_EQ(run({}).exit_code, 2);
    EXPECT_EQ(run({"swim"}).exit_code, 2);
    EXPECT_EQ(run({"upload"}).exit_code, 2);
    EXPECT_EQ(run({"reconstruct", "--explain", "--preset", "best"}).exit_code, 2);
    EXPECT_EQ(run({"reconstruct", "--explain", "--set", "voxel_m=x"}).exit_code, 2);
    EXPECT_EQ(run({"dives", "--server", "boat"}).exit_code, 2);
}

TEST_F(CommandLineTest, EndsWithOneAndSaysWhyWhenTheWorkFails) {
    const Outcome outcome = run({"validate", (folder / "nowhere").string()});
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_NE(outcome.err.find("nowhere"), std::string::npos) << outcome.err;
}

TEST_F(CommandLineTest, MakesNoFolderForADiveThatIsNotThere) {
    const Outcome outcome =
        run({"reconstruct", (folder / "nowhere").string(), "--out", (folder / "model").string()});
    EXPECT_EQ(outcome.exit_code, 1);
    EXPECT_NE(outcome.err.find("nowhere: check the path"), std::string::npos) << outcome.err;
    EXPECT_FALSE(fs::exists(folder / "model"));

    std::ofstream(folder / "file") << "no folder";
    const Outcome blocked =
        run({"reconstruct", folder.path().string(), "--out", (folder / "file/model").string()});
    EXPECT_EQ(blocked.exit_code, 2);
    EXPECT_NE(blocked.err.find("give another --out"), std::string::npos) << blocked.err;
}

TEST_F(CommandLineTest, TakesOptionsFromVariablesAndAConfigFile) {
    const auto preset_of = [](const Outcome& outcome) {
        return nlohmann::json::parse(outcome.out).at("estimator").get<std::string>();
    };
    EXPECT_EQ(preset_of(run({"reconstruct", "--explain", "--json"})), "window");
    EXPECT_EQ(
        preset_of(run({"reconstruct", "--explain", "--json"}, {{"DIVEMESH_PRESET", "paper"}})),
        "pairwise");
    std::ofstream(folder / "divemesh.toml") << "[reconstruct]\npreset = \"paper\"\n";
    EXPECT_EQ(preset_of(run({"reconstruct", "--explain", "--json"})), "pairwise");
    EXPECT_EQ(preset_of(run({"reconstruct", "--explain", "--json", "--preset", "standard"})),
              "window");
}

TEST_F(CommandLineTest, TakesTheColorsThatAreWanted) {
    const Outcome shown = run(
        {"reconstruct", "--explain", "--json", "--color", "restored", "--white-point", "1,2,3"});
    ASSERT_EQ(shown.exit_code, 0) << shown.err;
    const auto options = nlohmann::json::parse(shown.out);
    EXPECT_EQ(options.at("color"), "restored");
    EXPECT_EQ(options.at("white_point"), "1,2,3");
    EXPECT_EQ(run({"reconstruct", "--explain", "--color", "grey"}).exit_code, 2);
    EXPECT_EQ(run({"reconstruct", "--explain", "--white-point", "1,2"}).exit_code, 2);
}

TEST_F(CommandLineTest, TokensMadeAndRevokedAtTheServerAreNotedWithTheUser) {
    const std::string data = (folder / "data").string();
    const auto made = run({"token", "create", "--data", data, "--name", "laptop"});
    ASSERT_EQ(made.exit_code, 0) << made.err;
    const std::string id = made.err.substr(0, made.err.find(':'));
    EXPECT_EQ(run({"token", "revoke", "--data", data, id}).exit_code, 0);
    EXPECT_EQ(run({"token", "revoke", "--data", data, "token_none"}).exit_code, 1);

    storage::Catalog catalog("sqlite://" + data + "/catalog.db");
    const auto events = storage::EventStore(catalog).since(0, "", 10);
    ASSERT_EQ(events.size(), 2U) << "what was refused leaves none";
    EXPECT_EQ(events[0].data["path"], "token create laptop");
    EXPECT_EQ(events[1].data["path"], "token revoke " + id);
    for (const Event& event : events) {
        EXPECT_EQ(event.topic, "audit");
        EXPECT_TRUE(event.data["token_name"].get<std::string>().starts_with("command line, "));
        EXPECT_EQ(event.data.dump().find("dm_"), std::string::npos) << "no secret";
    }
}

// The metric is evo's own, published with its test data.
TEST_F(CommandLineTest, EvaluatesATrajectoryAsEvoDoes) {
    const fs::path evo = shared_data("evo");
    if (!fs::exists(evo)) GTEST_SKIP() << "no shared data: set DIVEMESH_SHARED";
    const Outcome outcome = run({"evaluate",
                                 "trajectory",
                                 "--json",
                                 "--estimate",
                                 (evo / "KITTI_00_ORB.txt").string(),
                                 "--reference",
                                 (evo / "KITTI_00_gt.txt").string()});
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_NEAR(nlohmann::json::parse(outcome.out).at("ate_rmse_m").get<double>(), 1.303450, 5e-7);
}

// A strip of 1 x 4 m of which the reference shows the first half.
TEST_F(CommandLineTest, AMeshIsFalseOnlyWhereTheSceneHasNothing) {
    const auto strip = [&](const char* name, double length_m) {
        const fs::path file = folder / name;
        std::ofstream(file) << "v 0 0 0\nv " << length_m << " 0 0\nv " << length_m
                            << " 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n";
        return file.string();
    };
    std::vector<std::string> arguments = {"evaluate",
                                          "mesh",
                                          "--json",
                                          "--estimate",
                                          strip("ours.obj", 4.0),
                                          "--reference",
                                          strip("reference.obj", 2.0)};
    const auto false_share = [&] {
        const Outcome outcome = run(arguments);
        EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
        return nlohmann::json::parse(outcome.out).at("false_share_50mm").get<double>();
    };
    EXPECT_NEAR(false_share(), 1.95 / 4.0, 2e-3);
    arguments.insert(arguments.end(), {"--scene", strip("scene.obj", 4.0)});
    EXPECT_EQ(false_share(), 0.0);
    std::ofstream(folder / "points.obj") << "v 0 0 0\nv 1 0 0\n";
    arguments.back() = (folder / "points.obj").string();
    const Outcome refused = run(arguments);
    EXPECT_EQ(refused.exit_code, 1);
    EXPECT_NE(refused.err.find("no triangles"), std::string::npos) << refused.err;
}

TEST_F(CommandLineTest, AReportEndsWithThreeWhenARequirementIsNotMet) {
    std::ofstream(folder / "metrics.json") << R"({"frames": {"coverage": 0.5}})";
    std::ofstream(folder / "trajectory.tum") << "1 0 0 0 0 0 0 1\n2 1 0 0 0 0 0 1\n";
    const auto report = [&](const std::vector<std::string>& more) {
        std::vector<std::string> arguments = {"report", folder.path().string()};
        arguments.insert(arguments.end(), more.begin(), more.end());
        return run(arguments);
    };
    EXPECT_EQ(report({}).exit_code, 0);
    EXPECT_EQ(report({"--require", "coverage>=0.5"}).exit_code, 0);
    const Outcome unmet = report({"--require",
                                  "coverage>=0.5",
                                  "--require",
                                  "drift_percent<=0.5",
                                  "--junit",
                                  (folder / "verdict.xml").string()});
    EXPECT_EQ(unmet.exit_code, 3) << unmet.err;
    std::ifstream stream(folder / "verdict.xml");
    const std::string xml{std::istreambuf_iterator<char>(stream), {}};
    EXPECT_NE(xml.find("tests=\"2\" failures=\"1\""), std::string::npos) << xml;
    const Outcome misspelt = report({"--require", "coverrage>=0.5"});
    EXPECT_EQ(misspelt.exit_code, 2);
    EXPECT_NE(misspelt.err.find("frames.coverage"), std::string::npos) << misspelt.err;
    EXPECT_EQ(report({"--ground-truth", (folder / "none.tum").string()}).exit_code, 1);
}

TEST_F(CommandLineTest, ADemoLeavesAMeshAndNoServerWhateverTheUserHasConfigured) {
    const fs::path out = folder / "demo";
    const Process::Environment environment = {{"XDG_STATE_HOME", folder.path().string()},
                                              {"DIVEMESH_CATALOG", "sqlite:///nowhere/catalog.db"},
                                              {"DIVEMESH_LISTEN", "nowhere"}};
    const auto demo = [&] {
        return run({"demo", small_dive().string(), "--out", out.string(), "--preset", "fast"},
                   environment);
    };
    const Outcome first = demo();
    ASSERT_EQ(first.exit_code, 0) << first.err;
    const fs::path mesh = out / "result" / "mesh.glb";
    EXPECT_EQ(first.out, mesh.string() + "\n");
    EXPECT_EQ(read_text(mesh).substr(0, 4), "glTF");
    EXPECT_NE(read_text(out / "server.log").find("worker_started"), std::string::npos);
    const Outcome second = demo();  // of the server that it finds in the folder
    EXPECT_EQ(second.exit_code, 0) << second.err;
    EXPECT_NE(second.err.find("already has this dive"), std::string::npos) << second.err;
}

TEST_F(CommandLineTest, StopsAReconstructionAtOnceWhenItIsInterrupted) {
    Process process({divemesh_program().string(),
                     "reconstruct",
                     small_dive().string(),
                     "--out",
                     (folder / "out").string()},
                    folder.path());
    ASSERT_TRUE(wait_until(60s, [&] {
        return process.stderr_text().find("track") != std::string::npos;
    })) << process.stderr_text();
    process.send(SIGINT);
    EXPECT_EQ(process.wait(10s), 1) << process.stderr_text();
    EXPECT_NE(process.stderr_text().find("interrupted"), std::string::npos);
    EXPECT_FALSE(fs::exists(folder / "out/metrics.json"));
}

}  // namespace
}  // namespace divemesh
