#include "worker/compare/compare.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validator.hpp>

#include "schemas/error.hpp"
#include "tests/paths.hpp"
#include "tests/synthetic/rough_ground.hpp"
#include "tests/synthetic/small_reconstruction.hpp"
#include "tests/temporary_folder.hpp"
#include "worker/evaluation/scaled_uncertainty.hpp"
#include "worker/io/trajectory_file.hpp"
#include "worker/types/path_uncertainty.hpp"

namespace divemesh::compare {
namespace {

using nlohmann::json;
using synthetic::ground_mesh;
using synthetic::HeightOf;
using synthetic::rough_ground;
using synthetic::write_reconstruction;

constexpr double kStep_m = 0.02;
constexpr double kNoise_m = 0.002;

std::string content(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

// The volume of a cone of 0.25 m radius and 0.2 m height, and of a hole of the same shape.
constexpr double kVolume_m3 = 3.14159265 * 0.25 * 0.25 * 0.2 / 3.0;
double cone(double x, double y) { return synthetic::cone(x, y, 0.25, 0.2); }

class CompareTest : public testing::Test {
protected:
    static void SetUpTestSuite() {
        folder_ = std::make_unique<TemporaryFolder>();
        const HeightOf ground = rough_ground(8);
        const HeightOf later = [ground](double x, double y) {
            return ground(x, y) + cone(x - 0.6, y - 0.3) - cone(x + 0.7, y + 0.2);
        };
        Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
        T.linear() = Eigen::AngleAxisd(1.2, Eigen::Vector3d::UnitZ()).toRotationMatrix();
        T.translation() = Eigen::Vector3d(2.0, 1.0, -0.4);
        write_reconstruction(*folder_ / "a", ground_mesh(ground, 1.6, 1.2, kStep_m, kNoise_m, 1));
        write_reconstruction(
            *folder_ / "b",
            synthetic::moved(ground_mesh(later, 1.6, 1.2, kStep_m, kNoise_m, 2), T));
        write_reconstruction(*folder_ / "again",
                             ground_mesh(ground, 1.6, 1.2, kStep_m, kNoise_m, 3));
    }
    static void TearDownTestSuite() { folder_.reset(); }

    json compare(const std::string& a, const std::string& b, int num_threads = 2) const {
        return compare_reconstructions({.a = *folder_ / a,
                                        .b = *folder_ / b,
                                        .out = *folder_ / ("out" + std::to_string(num_threads)),
                                        .num_threads = num_threads});
    }

    static inline std::unique_ptr<TemporaryFolder> folder_;
};

TEST_F(CompareTest, KnownVolumesLieWithinTheirIntervals) {
    const json document = compare("a", "b");
    for (const char* kind : {"grown", "lost"}) {
        EXPECT_EQ(document.at(kind).at("num_patches"), 1) << kind;
        const json& volume = document.at(kind).at("volume_m3");
        EXPECT_LE(volume.at("low").get<double>(), kVolume_m3) << kind;
        EXPECT_GE(volume.at("high").get<double>(), kVolume_m3) << kind;
        EXPECT_NEAR(volume.at("value").get<double>(), kVolume_m3, 0.05 * kVolume_m3) << kind;
        const json& area = document.at(kind).at("area_m2");
        EXPECT_LE(area.at("low").get<double>(), 0.196) << kind;
        EXPECT_GE(area.at("high").get<double>(), 0.196) << kind;
    }
    EXPECT_FALSE(document.at("ground").at("visibility_checked").get<bool>());
}

TEST_F(CompareTest, TheSameGroundHasNotChanged) {
    const json document = compare("a", "again");
    EXPECT_TRUE(document.at("patches").empty());
    EXPECT_LT(document.at("rest").at("beyond_share").get<double>(), 0.05);
    EXPECT_NEAR(document.at("distances").at("median_m").get<double>(), 0.0, 5e-4);
}

void expect_fits_the_schema(const json& document) {
    const json text =
        json::parse(std::ifstream(source_directory() / "schemas" / "compare.schema.json"));
    valijson::Schema schema;
    valijson::SchemaParser().populateSchema(valijson::adapters::NlohmannJsonAdapter(text), schema);
    valijson::ValidationResults problems;
    EXPECT_TRUE(valijson::Validator().validate(
        schema, valijson::adapters::NlohmannJsonAdapter(document), &problems))
        << problems.begin()->description << document.dump(1);
}

// Returns the finding with this code; null without it.
json finding(const json& document, const std::string& code) {
    for (const json& one : document.at("findings"))
        if (one.at("code") == code) return one;
    return nullptr;
}

TEST_F(CompareTest, ItsDocumentFitsTheSchema) {
    const json document = compare("a", "b");
    expect_fits_the_schema(document);
    EXPECT_TRUE(document.at("findings").empty()) << document.at("findings");
}

// The later dive lost the scene. What it saw afterwards, a plate at another place, lies beside the
// rest, over ground that the earlier dive knows.
TEST_F(CompareTest, TheMisplacedRestOfADiveInSegmentsIsNoChange) {
    const HeightOf ground = rough_ground(8);
    const HeightOf western = [ground](double x, double y) { return ground(x - 0.6, y); };
    types::Mesh mesh = ground_mesh(western, 1.0, 1.2, kStep_m, kNoise_m, 4);
    const types::Mesh plate =
        ground_mesh([](double, double) { return 0.3; }, 0.5, 1.2, kStep_m, kNoise_m, 5);
    Eigen::Isometry3d to_the_west = Eigen::Isometry3d::Identity();
    Eigen::Isometry3d to_the_east = Eigen::Isometry3d::Identity();
    to_the_west.translation().x() = -0.6;
    to_the_east.translation().x() = 1.1;
    mesh = synthetic::joined(synthetic::moved(mesh, to_the_west),
                             synthetic::moved(plate, to_the_east));
    write_reconstruction(
        *folder_ / "lost",
        mesh,
        {{"verdict", "usable_with_restrictions"},
         {"restrictions", {"path", "scale"}},
         {"pieces", {synthetic::segment_json(30, 0, 2), synthetic::segment_json(20, 3, 4)}}});
    synthetic::write_keyframes(*folder_ / "lost", {-1.4, -0.6, 0.2, 1.0, 1.4});

    const json document = compare("a", "lost");

    EXPECT_NEAR(document.at("ground").at("both_m2").get<double>(), 2.0 * 2.4, 0.15);
    EXPECT_LT(document.at("grown").at("volume_m3").at("high").get<double>(), 0.02);
    EXPECT_EQ(document.at("b").at("num_segments"), 2);
    EXPECT_EQ(document.at("b").at("segment"), 0);
    EXPECT_EQ(document.at("b").at("restrictions"), (json{"path", "scale"}));
    EXPECT_EQ(finding(document, "dive_in_segments")["where"], "later dive");
    EXPECT_EQ(finding(document, "dive_restricted")["where"], "later dive");
    expect_fits_the_schema(document);
    EXPECT_NE(content(*folder_ / "out2/report.html").find("30 of 50 frames"), std::string::npos);
}

TEST_F(CompareTest, AScaleThatTheStatedOnesDoNotAllowIsTold) {
    types::Mesh larger = ground_mesh(rough_ground(8), 1.6, 1.2, kStep_m, kNoise_m, 6);
    for (Eigen::Vector3f& p : larger.vertices) p *= 1.015F;
    write_reconstruction(*folder_ / "larger", larger, {{"calibration", {{"scale_sigma", 0.004}}}});

    const json document = compare("a", "larger");

    const json& shown = document.at("registration").at("scale_difference");
    EXPECT_NEAR(shown.at("value").get<double>(), 0.015, 0.002);
    EXPECT_LT(shown.at("sigma").get<double>(), 0.002);
    EXPECT_EQ(document.at("b").at("scale_sigma"), 0.004);
    EXPECT_EQ(document.at("a").at("scale_sigma"), types::kCalibrationSigma);
    EXPECT_NE(finding(document, "scales_differ"), nullptr);
    expect_fits_the_schema(document);
}

TEST_F(CompareTest, AScaleThatIsKnownLessWellThanTheVolumesIsTold) {
    write_reconstruction(*folder_ / "vague",
                         io::read_ply(*folder_ / "b/mesh.ply"),
                         {{"calibration", {{"scale_sigma", 0.05}}}});
    const json document = compare("a", "vague");
    EXPECT_EQ(finding(document, "scales_differ"), nullptr);
}

// Another measurement says that all lengths of the later dive are 5 % longer. Far from its path the
// sigmas of its mesh contain that; the change does not.
TEST_F(CompareTest, AScaleThatContradictsIsNoNoiseOfTheChange) {
    const types::Mesh mesh = io::read_ply(*folder_ / "b/mesh.ply");
    types::Trajectory path(1);
    path[0].T_world_imu.translation() = Eigen::Vector3d(2.0, 1.0, 1.5);
    constexpr double kContradiction = 0.05;
    const double sigma = evaluation::contradiction_sigma(kContradiction);
    const types::Mesh covering = evaluation::with_scale_sigma(mesh, path, {}, 0.0, sigma);
    ASSERT_GT(*std::ranges::max_element(covering.sigma_m), 10.0F * kNoise_m);
    write_reconstruction(
        *folder_ / "contradicted",
        covering,
        {{"calibration",
          {{"scale_sigma", std::hypot(0.002, sigma)}, {"scale_contradiction", kContradiction}}}});
    io::write_tum(*folder_ / "contradicted/trajectory.tum", path);

    const json expected = compare("a", "b");
    const json document = compare("a", "contradicted");

    const auto expect_same = [&](const char* pointer) {
        const json::json_pointer place(pointer);
        const double value = expected.at(place).get<double>();
        EXPECT_NEAR(document.at(place).get<double>(), value, 0.01 * std::abs(value)) << pointer;
    };
    for (const char* pointer : {"/distances/median_lod95_m",
                                "/distances/level_factor",
                                "/grown/volume_m3/low",
                                "/grown/volume_m3/high",
                                "/lost/volume_m3/low",
                                "/lost/volume_m3/high"})
        expect_same(pointer);
    expect_fits_the_schema(document);
}

TEST_F(CompareTest, AVerticalThatIsNotKnownIsTold) {
    write_reconstruction(*folder_ / "tilted",
                         io::read_ply(*folder_ / "b/mesh.ply"),
                         {{"trajectory", {{"vertical_known", false}}}});
    const json document = compare("a", "tilted");
    EXPECT_EQ(finding(document, "vertical_unknown")["where"], "later dive");
    expect_fits_the_schema(document);
}

TEST_F(CompareTest, ARefusalNamesTheVerticalThatIsNotKnown) {
    const HeightOf flat = [](double, double) { return 0.0; };
    for (const bool known : {true, false}) {
        write_reconstruction(*folder_ / "flat",
                             ground_mesh(flat, 0.8, 0.8, kStep_m, kNoise_m, 7),
                             {{"trajectory", {{"vertical_known", known}}}});
        try {
            compare("a", "flat");
            ADD_FAILURE() << "aligned";
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ErrorCode::Conflict);
            const std::string message = error.what();
            EXPECT_EQ(message.find("which way is up in the later dive") == std::string::npos, known)
                << message;
        }
    }
}

TEST_F(CompareTest, ThreadsChangeNoByte) {
    compare("a", "b", 1);
    compare("a", "b", 3);
    for (const char* file : {"compare.json",
                             "report.html",
                             "changed_mesh.ply",
                             "mosaic_difference.png",
                             "mosaic_difference.json",
                             "change_height.png"})
        EXPECT_TRUE(content(*folder_ / "out1" / file) == content(*folder_ / "out3" / file)) << file;
}

TEST_F(CompareTest, TheReportIsOnePageAndEscapesNames) {
    compare("a", "b");
    const std::string html = content(*folder_ / "out2/report.html");
    EXPECT_NE(html.find("&lt;b&gt;a&lt;/b&gt;"), std::string::npos);
    EXPECT_EQ(html.find("<script"), std::string::npos);
    EXPECT_EQ(html.find("http"), std::string::npos);
}

TEST_F(CompareTest, AFolderWithoutSurfaceIsRefusedByName) {
    std::filesystem::create_directory(*folder_ / "bare");
    std::filesystem::copy(
        *folder_ / "b", *folder_ / "bare", std::filesystem::copy_options::recursive);
    std::filesystem::remove(*folder_ / "bare/mesh.ply");
    try {
        compare("a", "bare");
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::BadData);
        EXPECT_NE(std::string(error.what()).find("mesh.ply"), std::string::npos);
    }
}

}  // namespace
}  // namespace divemesh::compare
