#include "worker/io/certificate.hpp"

#include <algorithm>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validator.hpp>

#include "tests/paths.hpp"
#include "tests/worker/io/exported_folder.hpp"
#include "worker/io/exports.hpp"

namespace divemesh::io {
namespace {

using nlohmann::json;

class CertificateTest : public ExportedFolderTest {
protected:
    static bool is_valid(const json& document) {
        const json text =
            json::parse(std::ifstream(source_directory() / "schemas/certificate.schema.json"));
        valijson::Schema schema;
        valijson::SchemaParser().populateSchema(valijson::adapters::NlohmannJsonAdapter(text),
                                                schema);
        return valijson::Validator().validate(
            schema, valijson::adapters::NlohmannJsonAdapter(document), nullptr);
    }
};

TEST_F(CertificateTest, StatesDiveProgramAndAccuracy) {
    const json certificate = certificate_of(metrics());

    EXPECT_TRUE(is_valid(certificate)) << certificate;
    EXPECT_EQ(certificate["dive"]["content_sha256"], "0123456789abcdef");
    EXPECT_EQ(certificate["version"], "0.1.0");
    EXPECT_EQ(certificate["calibration"], json({{"sha256", "fedc"}}));
    EXPECT_EQ(certificate["accuracy"],
              json({{"calibration.scale_sigma", 0.00293},
                    {"expected_accuracy.level", 0.95},
                    {"expected_accuracy.surface.sigma_median_m", 0.011}}));
    EXPECT_EQ(certificate["findings"],
              json::array({{{"severity", "warning"}, {"code", "no_imu"}}}));
}

TEST_F(CertificateTest, ItsDateIsThatOfTheRecording) {
    EXPECT_EQ(certificate_of(metrics())["dive"]["recorded_utc"], "2014-06-24T19:03:04Z");
    json unset = metrics();
    unset["pieces"][0]["intervals"][0]["first_ns"] = 5'000'000'000;  // since the camera's start
    EXPECT_FALSE(certificate_of(unset)["dive"].contains("recorded_utc"));
}

TEST_F(CertificateTest, TimesAndThreadsOfTheRunDoNotChangeIt) {
    json again = metrics();
    again["options"]["num_threads"] = 1;
    again["speed"]["wall_s"] = 99.0;

    EXPECT_EQ(certificate_of(again).dump(), certificate_of(metrics()).dump());
}

TEST_F(CertificateTest, LeavesOutWhatOlderVersionsDoNotState) {
    const json certificate = certificate_of(json::object());

    EXPECT_TRUE(is_valid(certificate));
    EXPECT_EQ(certificate, json({{"format", 1}, {"accuracy", json::object()}}));
    EXPECT_EQ(certificate_line(certificate), "divemesh of an older version; verdict: not stated");
}

TEST_F(CertificateTest, LeavesOutWhatWasNotMeasured) {
    json unmeasured = metrics();
    unmeasured["trajectory"]["final"]["drift_percent"] = nullptr;
    const json accuracy = certificate_of(unmeasured).at("accuracy");
    EXPECT_FALSE(accuracy.contains("trajectory.final.drift_percent"));
    unmeasured["trajectory"]["final"]["drift_percent"] = 0.5;
    EXPECT_EQ(certificate_of(unmeasured).at("accuracy").at("trajectory.final.drift_percent"), 0.5);
}

TEST_F(CertificateTest, ItsLineStatesVerdictAndAccuracy) {
    EXPECT_EQ(certificate_line(certificate_of(metrics())),
              "divemesh 0.1.0; verdict: usable with restrictions: path, scale; scale 0.293 % (1 "
              "sigma); surface 11 mm (median sigma); dive 0123456789ab");
}

TEST_F(CertificateTest, ItsLineStaysOneLineWhateverMetricsJsonSays) {
    json hostile = metrics();
    hostile["restrictions"] = {"a\nend_header\n", std::string(100'000, 'x')};

    const std::string line = certificate_line(certificate_of(hostile));

    EXPECT_LE(line.size(), 400U);
    EXPECT_TRUE(std::all_of(line.begin(), line.end(), [](char c) { return c >= ' ' && c <= '~'; }));
}

TEST_F(CertificateTest, FieldsOfAnotherTypeAreBadData) {
    for (const json& changed : {json{{"version", 1}},
                                json{{"calibration", {{"scale_sigma", "small"}}}},
                                json{{"options", 7}},
                                json{{"findings", {{{"severity", 1}}}}},
                                json{{"findings", 3}},
                                json{{"restrictions", "all"}},
                                json{{"pieces", {{{"intervals", {{{"first_ns", "x"}}}}}}}},
                                json{{"pieces", 5}}}) {
        const Error error = error_of([&] { certificate_of(changed); });
        EXPECT_EQ(error.code(), ErrorCode::BadData) << changed;
        EXPECT_NE(std::string(error.what()).find("metrics.json"), std::string::npos);
    }
}

TEST_F(CertificateTest, GoesWithEveryExport) {
    export_reconstruction(open(), {}, std::nullopt, file("out"));

    EXPECT_EQ(json::parse(read(file("out/certificate.json"))), certificate_of(metrics()));
}

}  // namespace
}  // namespace divemesh::io
