#include "worker/report/accuracy_report.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validator.hpp>

#include "schemas/error.hpp"
#include "tests/paths.hpp"
#include "tests/temporary_folder.hpp"
#include "worker/camera/projection.hpp"
#include "worker/io/covariance_file.hpp"
#include "worker/io/ply.hpp"
#include "worker/io/rig_json.hpp"
#include "worker/io/trajectory_file.hpp"

namespace divemesh::report {
namespace {

using nlohmann::json;

constexpr char kHostileName[] = "=cmd <script>alert('x')</script> \"&";

bool is_valid(const json& report) {
    const json text =
        json::parse(std::ifstream(source_directory() / "schemas" / "report.schema.json"));
    valijson::Schema schema;
    valijson::SchemaParser().populateSchema(valijson::adapters::NlohmannJsonAdapter(text), schema);
    return valijson::Validator().validate(
        schema, valijson::adapters::NlohmannJsonAdapter(report), nullptr);
}

// Returns a square of 2 m with cells of 0.1 m.
types::Mesh square(float z_m) {
    types::Mesh mesh;
    constexpr std::uint32_t kSide = 21;
    for (std::uint32_t row = 0; row < kSide; ++row)
        for (std::uint32_t column = 0; column < kSide; ++column)
            mesh.vertices.emplace_back(
                0.1F * static_cast<float>(column), 0.1F * static_cast<float>(row), z_m);
    for (std::uint32_t row = 0; row + 1 < kSide; ++row)
        for (std::uint32_t column = 0; column + 1 < kSide; ++column) {
            const std::uint32_t corner = row * kSide + column;
            mesh.triangles.push_back({corner, corner + 1, corner + kSide + 1});
            mesh.triangles.push_back({corner, corner + kSide + 1, corner + kSide});
        }
    return mesh;
}

// Returns the path of a rig 1 m above the square that sways about all axes; `offset_s` is the
// offset of its clock.
types::Trajectory sway(double offset_s, const Eigen::Vector3d& lever_m) {
    types::Trajectory trajectory;
    for (int i = 0; i < 400; ++i) {
        const double t = 0.1 * i;
        Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
        pose.translation() = Eigen::Vector3d(
            1.0 + 0.9 * std::sin(0.5 * t), 1.0 + 0.9 * std::cos(0.31 * t), 1.0 + 0.1 * std::sin(t));
        pose.rotate(Eigen::AngleAxisd(0.5 * std::sin(0.7 * t), Eigen::Vector3d::UnitZ()));
        pose.rotate(Eigen::AngleAxisd(0.4 * std::sin(0.9 * t), Eigen::Vector3d::UnitX()));
        pose.translate(lever_m);
        trajectory.push_back({1'000'000'000 + std::llround((t + offset_s) * 1e9), pose});
    }
    return trajectory;
}

class AccuracyReportTest : public testing::Test {
protected:
    AccuracyReportTest() {
        std::filesystem::create_directories(folder_ / "result");
        const json metrics = {
            {"version", "0.1.0"},
            {"preset", "standard"},
            {"dive", {{"name", kHostileName}, {"content_sha256", "abc"}, {"duration_s", 40.0}}},
            {"calibration", {{"sha256", "def"}, {"baseline_m", 0.12}}},
            {"frames", {{"num_frames", 400}, {"coverage", 1.0}}},
            {"trajectory", {{"path_length_m", 20.0}}},
            {"markers",
             {{"markers",
               {{{"id", 7},
                 {"position_m", {0.1, 0.2, 0.3}},
                 {"sigma_m", 0.001},
                 {"num_keyframes", 9}}}},
              {"bars",
               {{{"name", kHostileName},
                 {"from", {{"id", 7}, {"corner", "top_left"}}},
                 {"to", 8},
                 {"known_m", 0.5},
                 {"measured_m", 0.501},
                 {"error_mm", 1.0}}}}}},
            {"known_distances",
             {{"distances",
               {{{"name", kHostileName}, {"known_m", 1.0}, {"measured_m", 1.002}},
                {{"name", "unseen"}, {"known_m", 1.0}, {"measured_m", nullptr}}}}}}};
        std::ofstream(folder_ / "result/metrics.json") << metrics;
        io::write_tum(folder_ / "result/trajectory.tum", sway(0.0, Eigen::Vector3d::Zero()));
        io::write_ply(folder_ / "result/mesh.ply", square(0.003F));
        io::write_tum(folder_ / "truth.tum", sway(0.0, Eigen::Vector3d::Zero()));
        io::write_ply(folder_ / "reference.ply", square(0.0F));
        request_.reconstruction = folder_ / "result";
        request_.out = folder_ / "out";
        request_.scratch = folder_ / "scratch";
        request_.num_surface_samples = 20'000;
        request_.num_threads = 1;
    }

    void give_verdict(const std::string& verdict, const json& restrictions, const json& findings) {
        json metrics = json::parse(std::ifstream(folder_ / "result/metrics.json"));
        metrics["verdict"] = verdict;
        metrics["restrictions"] = restrictions;
        metrics["findings"] = findings;
        std::ofstream(folder_ / "result/metrics.json") << metrics;
    }
    json make() { return make_accuracy_report(request_, base::ignore_progress); }
    void give_truth() {
        request_.ground_truth = folder_ / "truth.tum";
        request_.reference = folder_ / "reference.ply";
    }
    std::string read(const std::string& name) const {
        std::ifstream stream(request_.out / name, std::ios::binary);
        return {std::istreambuf_iterator<char>(stream), {}};
    }
    static json metric(const json& report, const std::string& name) {
        for (const json& entry : report.at("figures"))
            if (entry.at("figure") == name) return entry;
        ADD_FAILURE() << "no " << name;
        return json();
    }

    TemporaryFolder folder_;
    AccuracyReportRequest request_;
};

TEST_F(AccuracyReportTest, MeasuresPathAndSurfaceAgainstTheTruth) {
    give_truth();
    const json report = make();
    EXPECT_TRUE(is_valid(report));
    EXPECT_LT(metric(report, "trajectory.final.ate_rmse_m")["value"].get<double>(), 1e-6);
    EXPECT_NEAR(metric(report, "surface.accuracy.median_m")["value"].get<double>(), 0.003, 1e-5);
    EXPECT_EQ(metric(report, "surface.accuracy.median_m")["unit"], "m");
    EXPECT_EQ(report["reconstruction"]["calibration_sha256"], "def");
    EXPECT_EQ(report["truth"]["source"], "truth.tum");
    EXPECT_EQ(report["files"].size(), 5U);
    EXPECT_TRUE(report["findings"].empty());
    EXPECT_TRUE(report["passed"].is_null());
}

// Two segments whose positions relative to each other are a guess that is off by 5 m.
TEST_F(AccuracyReportTest, FinalAndCausalPathOfSeveralSegmentsAreComparedOverTheLargest) {
    constexpr std::size_t kSecond = 250;
    types::Trajectory apart = sway(0.0, Eigen::Vector3d::Zero());
    const auto interval = [&](std::size_t first, std::size_t last) {
        return json{
            {"num_frames", last + 1 - first},
            {"intervals",
             {{{"first_ns", apart[first].timestamp_ns}, {"last_ns", apart[last].timestamp_ns}}}}};
    };
    json metrics = json::parse(std::ifstream(folder_ / "result/metrics.json"));
    metrics["pieces"] =
        json::array({interval(0, kSecond - 1), interval(kSecond, apart.size() - 1)});
    std::ofstream(folder_ / "result/metrics.json") << metrics;
    for (std::size_t i = kSecond; i < apart.size(); ++i)
        apart[i].T_world_imu.translation().x() += 5.0;
    io::write_tum(folder_ / "result/trajectory.tum", apart);
    io::write_tum(folder_ / "result/trajectory_causal.tum", apart);
    give_truth();
    const json report = make();
    for (const std::string path : {"trajectory.final.", "trajectory.causal."}) {
        EXPECT_EQ(metric(report, path + "num_poses")["value"], kSecond);
        EXPECT_LT(metric(report, path + "ate_rmse_m")["value"].get<double>(), 1e-6);
    }
}

TEST_F(AccuracyReportTest, WithoutTruthTheMetricsOfTheReconstructionRemain) {
    request_.requirements = {"coverage>=1", "drift_percent<=0.5"};
    const json report = make();
    EXPECT_TRUE(is_valid(report));
    EXPECT_EQ(report["requirements"][0]["met"], true);
    EXPECT_EQ(report["requirements"][1]["met"], false);
    EXPECT_EQ(report["passed"], false);
    EXPECT_NE(read("junit.xml").find("needs ground truth"), std::string::npos);
}

TEST_F(AccuracyReportTest, AnExternalTrackersLeverArmAndClockAreSolvedAndStated) {
    give_truth();
    const Eigen::Vector3d lever_m(0.2, -0.1, 0.15);
    io::write_tum(folder_ / "truth.tum", sway(2.5, lever_m));
    request_.truth.solve_lever_arm = true;
    request_.truth.solve_time_offset = true;
    const json report = make();
    EXPECT_TRUE(is_valid(report));
    EXPECT_NEAR(report["truth"]["time_offset_s"]["value"].get<double>(), 2.5, 1e-3);
    EXPECT_EQ(report["truth"]["time_offset_s"]["how"], "solved");
    EXPECT_TRUE(report["truth"]["lever_arm_m"].contains("sigma"));
    for (int axis = 0; axis < 3; ++axis)
        EXPECT_NEAR(
            metric(report, "truth.lever_arm_m.vector[" + std::to_string(axis) + "]")["value"]
                .get<double>(),
            lever_m[axis],
            2e-3);
    EXPECT_LT(metric(report, "trajectory.final.ate_rmse_m")["value"].get<double>(), 2e-3);
}

TEST_F(AccuracyReportTest, ACloudAsReferenceSaysHowDenseItIs) {
    give_truth();
    types::Mesh cloud = square(0.0F);
    cloud.triangles.clear();
    io::write_ply(folder_ / "reference.ply", cloud);
    const json report = make();
    EXPECT_NEAR(metric(report, "surface.reference_spacing_m")["value"].get<double>(), 0.1, 1e-4);
    EXPECT_NEAR(
        metric(report, "surface.completeness.median_m")["value"].get<double>(), 0.003, 1e-5);
    // The mean distance to the nearest point of a square lattice is 0.3826 of the spacing.
    EXPECT_NEAR(metric(report, "surface.accuracy.mean_m")["value"].get<double>(), 0.0383, 5e-4);
}

TEST_F(AccuracyReportTest, TagsAndTheLengthsBetweenThemAreShownAndAreMetrics) {
    const json report = make();
    EXPECT_EQ(metric(report, "markers.markers[7].sigma_m")["unit"], "m");
    EXPECT_EQ(metric(report, std::string("markers.bars[") + kHostileName + "].error_mm")["value"],
              1.0);
    EXPECT_NE(read("report.html").find("Length between tags"), std::string::npos);
}

// Two ends of a length that cameras saw whose lenses, mounting and baseline are not as stated.
TEST_F(AccuracyReportTest, LengthsAreMeasuredWithTheRigAndTheScaleOfTheResult) {
    types::Rig used;
    used.cam0 = {640, 480, 505.0, 506.0, 318.0, 243.0, types::Distortion::RadialTangential};
    used.cam0.distortion_coefficients = {-0.12, 0.03, 0.001, -0.002};
    used.cam1 = used.cam0;
    used.cam1.cx_px = 324.0;
    used.T_imu_cam0.linear() =
        Eigen::AngleAxisd(3.1, Eigen::Vector3d(1.0, 0.02, 0.01).normalized()).toRotationMatrix();
    used.T_imu_cam1 = used.T_imu_cam0 * Eigen::Translation3d(0.1234, 0.001, -0.002);
    constexpr double kScaleSigma = 0.004;
    json metrics = json::parse(std::ifstream(folder_ / "result/metrics.json"));
    metrics["calibration"]["rig"] = io::to_json(used);
    metrics["calibration"]["scale_sigma"] = kScaleSigma;
    std::ofstream(folder_ / "result/metrics.json") << metrics;
    const types::Trajectory path = sway(0.0, Eigen::Vector3d::Zero());
    types::CovarianceTrack exact;
    for (const types::StampedPose& pose : path)
        exact.push_back({.timestamp_ns = pose.timestamp_ns});
    io::write_covariances(folder_ / "result/trajectory_covariance.csv", exact);
    const Eigen::Vector3d ends[] = {{0.8, 0.9, 0.0}, {1.2, 1.2, 0.1}};
    json known = {{"name", "rib"}, {"distance_m", (ends[1] - ends[0]).norm()}};
    for (const int end : {0, 1}) {
        json& marks = known[end == 0 ? "marks_a" : "marks_b"];
        for (std::size_t i = 0; i < path.size(); i += 10) {
            json mark = {{"timestamp_ns", path[i].timestamp_ns}};
            for (const bool right : {false, true}) {
                const auto pixel = camera::project(
                    right ? used.cam1 : used.cam0,
                    (path[i].T_world_imu * (right ? used.T_imu_cam1 : used.T_imu_cam0)).inverse() *
                        ends[end]);
                if (pixel) mark[right ? "right" : "left"] = {pixel->x(), pixel->y()};
            }
            if (mark.contains("left")) marks.push_back(mark);
        }
    }
    std::ofstream(folder_ / "lengths.json") << json{{"distances", json::array({known})}};
    request_.measurements = folder_ / "lengths.json";
    const json report = make();
    EXPECT_TRUE(is_valid(report));
    const std::string rib = "known_distances.distances[rib].";
    const double known_m = known["distance_m"];
    EXPECT_NEAR(metric(report, rib + "measured_m")["value"].get<double>(), known_m, 1e-6);
    EXPECT_NEAR(metric(report, rib + "interval95_m[1]")["value"].get<double>() - known_m,
                1.96 * kScaleSigma * known_m,
                1e-6);
}

TEST_F(AccuracyReportTest, AreasGiveReefMetricsWithIntervalsToRequire) {
    std::ofstream(folder_ / "areas.json")
        << R"({"frame": "world", "areas": [{"name": "q1", "kind": "quadrat",
               "corners": [[0.5, 0.5, 0], [1.5, 0.5, 0], [1.5, 1.5, 0], [0.5, 1.5, 0]]}]})";
    request_.areas = folder_ / "areas.json";
    request_.requirements = {"reef.planar_area[q1]>=0.99", "reef.nothing[q1]<=1"};
    const json report = make();
    EXPECT_TRUE(is_valid(report));
    EXPECT_NEAR(metric(report, "reef.planar_area[q1]")["value"].get<double>(), 1.0, 1e-3);
    EXPECT_TRUE(metric(report, "reef.planar_area[q1].low")["value"].is_number());
    EXPECT_EQ(report["requirements"][0]["met"], true);
    EXPECT_EQ(report["requirements"][1]["met"], false);
    EXPECT_NE(read("report.html").find("Reef and wreck metrics"), std::string::npos);
    EXPECT_NE(read("report.csv").find("reef.planar_area[q1],"), std::string::npos);
}

TEST_F(AccuracyReportTest, ATruthOfAnotherTimeIsAFindingAndNoMetric) {
    give_truth();
    io::write_tum(folder_ / "truth.tum", sway(5000.0, Eigen::Vector3d::Zero()));
    request_.requirements = {"ate_rmse_m<=1"};
    const json report = make();
    EXPECT_TRUE(is_valid(report));
    EXPECT_EQ(report["findings"][0]["code"], "ground_truth_unusable");
    EXPECT_EQ(report["passed"], false);
}

TEST_F(AccuracyReportTest, NoRequirementOnAResultThatIsNotUsableIsMet) {
    give_truth();
    give_verdict("not_usable",
                 {"all"},
                 {{{"severity", "error"},
                   {"code", "diverged"},
                   {"where", ""},
                   {"message", "the path is <nowhere>"},
                   {"remedy", "swim slower"}}});
    request_.requirements = {"ate_rmse_m<=1", "coverage>=1"};
    const json report = make();
    EXPECT_TRUE(is_valid(report));
    EXPECT_EQ(report["reconstruction"]["verdict"], "not_usable");
    EXPECT_EQ(report["reconstruction"]["restrictions"], json({"all"}));
    EXPECT_EQ(report["reconstruction"]["findings"][0]["code"], "diverged");
    EXPECT_TRUE(report["findings"].empty());
    for (const json& requirement : report["requirements"]) {
        EXPECT_EQ(requirement["met"], false);
        EXPECT_TRUE(requirement["value"].is_number());
        EXPECT_EQ(requirement["reason"],
                  "the reconstruction is not usable (diverged): the path is <nowhere>");
    }
    EXPECT_EQ(report["passed"], false);
    EXPECT_NE(read("report.html").find("<b>Not usable</b>"), std::string::npos);
    EXPECT_NE(read("report.html").find("swim slower"), std::string::npos);
    EXPECT_NE(read("junit.xml").find("value=\"not_usable\""), std::string::npos);
    EXPECT_NE(read("junit.xml").find("error diverged: the path"), std::string::npos);
    EXPECT_NE(read("junit.xml").find("failures=\"2\""), std::string::npos);
}

TEST_F(AccuracyReportTest, OfADiveOfWhichNothingWasTrackedNoRequirementIsMet) {
    give_truth();
    give_verdict("not_usable",
                 {"all"},
                 {{{"severity", "error"},
                   {"code", "nothing_reconstructed"},
                   {"where", ""},
                   {"message", "there is no model"},
                   {"remedy", "swim slower"}}});
    std::ofstream(folder_ / "result/trajectory.tum") << "# timestamp tx ty tz qx qy qz qw\n";
    request_.requirements = {"ate_rmse_m<=1"};
    const json report = make();
    EXPECT_TRUE(is_valid(report));
    ASSERT_EQ(report["requirements"].size(), 1U);
    EXPECT_EQ(report["requirements"][0]["met"], false);
    EXPECT_EQ(report["passed"], false);
    EXPECT_NE(read("report.html").find("<b>Not usable</b>"), std::string::npos);
    EXPECT_EQ(read("report.html").find("nan"), std::string::npos);
    EXPECT_NE(read("junit.xml").find("failures=\"1\""), std::string::npos);
}

TEST_F(AccuracyReportTest, WhatRestrictsTheResultIsInEveryFormat) {
    give_verdict("usable_with_restrictions",
                 {"path"},
                 {{{"severity", "warning"},
                   {"code", "tracking_lost"},
                   {"where", "frame 7"},
                   {"message", "vision lost the ground"},
                   {"remedy", ""}}});
    request_.requirements = {"coverage>=1"};
    const json report = make();
    EXPECT_TRUE(is_valid(report));
    EXPECT_EQ(report["passed"], true);
    EXPECT_EQ(report["reconstruction"]["findings"][0]["code"], "tracking_lost");
    EXPECT_NE(read("report.html").find("Usable with restrictions: path"), std::string::npos);
    EXPECT_NE(read("report.html").find("vision lost the ground"), std::string::npos);
    EXPECT_NE(read("junit.xml").find("tracking_lost: frame 7: vision lost"), std::string::npos);
}

TEST_F(AccuracyReportTest, WhatNamesHoldComesOutAsTextAlone) {
    give_truth();
    request_.requirements = {"coverage>=1"};
    make();
    const std::string html = read("report.html");
    EXPECT_EQ(html.find("<script"), std::string::npos);
    EXPECT_NE(html.find("&lt;script&gt;"), std::string::npos);
    for (const char* loads : {"http://", "https://", "url(", "src=\"/", "@import", "<link"})
        EXPECT_EQ(html.find(loads), std::string::npos) << loads;
    EXPECT_EQ(read("junit.xml").find("<script"), std::string::npos);
    EXPECT_EQ(read("report.csv").find("\n="), std::string::npos);
}

TEST_F(AccuracyReportTest, IsTheSameWhateverTheNumberOfThreads) {
    give_truth();
    make();
    const std::string files[] = {read("report.json"), read("report.csv"), read("report.html")};
    request_.num_threads = 2;
    make();
    EXPECT_EQ(read("report.json"), files[0]);
    EXPECT_EQ(read("report.csv"), files[1]);
    EXPECT_EQ(read("report.html"), files[2]);
}

TEST_F(AccuracyReportTest, AWrongRequirementIsRefusedBeforeAnyWork) {
    request_.reconstruction = folder_ / "nowhere";
    request_.requirements = {"nonsense<=1"};
    try {
        make();
        FAIL() << "was taken";
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::InvalidArgument);
    }
}

TEST_F(AccuracyReportTest, ACancelledReportLeavesNothing) {
    EXPECT_THROW(
        make_accuracy_report(
            request_, [](const Progress&) { throw Error(ErrorCode::Cancelled, "cancelled"); }),
        Error);
    EXPECT_FALSE(std::filesystem::exists(request_.out / "report.json"));
}

}  // namespace
}  // namespace divemesh::report
