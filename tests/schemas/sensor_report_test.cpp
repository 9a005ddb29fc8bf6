// Compares the reader of reports with schemas/sensor-report.schema.json, by which others program
// their devices.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <valijson/adapters/nlohmann_json_adapter.hpp>
#include <valijson/schema.hpp>
#include <valijson/schema_parser.hpp>
#include <valijson/validator.hpp>

#include "schemas/invalid_input.hpp"
#include "schemas/sensor_message.hpp"
#include "schemas/sensor_status.hpp"
#include "tests/paths.hpp"

namespace divemesh {
namespace {

using nlohmann::json;

json schema_document() {
    return json::parse(std::ifstream(source_directory() / "schemas/sensor-report.schema.json"));
}

bool fits_schema(const json& report) {
    valijson::Schema schema;
    const json document = schema_document();
    valijson::SchemaParser().populateSchema(valijson::adapters::NlohmannJsonAdapter(document),
                                            schema);
    return valijson::Validator().validate(
        schema, valijson::adapters::NlohmannJsonAdapter(report), nullptr);
}

// Returns the place of the error that the reader finds; "" if it accepts the report.
std::string fault_of(const json& report) {
    try {
        sensor_report(report);
        return "";
    } catch (const InvalidInput& invalid) {
        return invalid.faults().at(0).pointer;
    }
}

json good_report() {
    return json::parse(R"({
        "boot_id": "8f3a-1", "lost": [[3, 5]],
        "messages": [
            {"seq": 0, "uptime_ms": 1200, "hello": {"firmware": "2.1", "capabilities": ["record"]}},
            {"seq": 1, "uptime_ms": 2200, "time_ms": 1795000000000, "status": {
                "recording": true, "dive": "wreck", "num_frames": 1200, "battery": 0.75,
                "depth_m": -0.2, "temperature_c": 11.5, "leak": false, "humidity": 0.3,
                "orientation": [1, 0, 0, 0], "errors": ["imu: 3 samples late"],
                "pictures": {"dark": 0.01}, "dive_plan": {"back_in_s": 2400},
                "link_rssi_dbm": null, "vendor": {"fan_rpm": 900}}},
            {"seq": 2, "uptime_ms": 1000, "historical": true, "status": {}}]})");
}

json with(const std::string& pointer, const json& value) {
    json report = good_report();
    report[json::json_pointer(pointer)] = value;
    return report;
}

TEST(SensorReportTest, ReadsWhatTheSchemaDescribes) {
    EXPECT_TRUE(fits_schema(good_report()));
    const SensorReport report = sensor_report(good_report());
    EXPECT_EQ(report.boot_id, "8f3a-1");
    ASSERT_EQ(report.messages.size(), 3U);
    EXPECT_EQ(report.messages[0].kind, MessageKind::Hello);
    EXPECT_EQ(report.messages[1].time_ms, 1795000000000);
    EXPECT_EQ(report.messages[1].body.at("vendor").at("fan_rpm"), 900) << "unknown fields stay";
    EXPECT_TRUE(report.messages[2].historical);
    ASSERT_EQ(report.lost.size(), 1U);
    EXPECT_EQ(report.lost[0].last, 5);
}

struct BadReport {
    std::string pointer;
    json value;
};

TEST(SensorReportTest, RefusesWhatTheSchemaRefusesAndSaysWhereItIs) {
    const std::string status = "/messages/1/status/";
    const std::vector<BadReport> bad = {
        {"/boot_id", ""},
        {"/boot_id", "../../etc"},
        {"/boot_id", std::string(65, 'a')},
        {"/boot_id", 7},
        {"/messages", json::object()},
        {"/messages", json(1001, json::object())},
        {"/messages/1", "text"},
        {"/messages/1/seq", -1},
        {"/messages/1/seq", 1.5},
        {"/messages/1/seq", 1e300},
        {"/messages/1/seq", 18'446'744'073'709'551'615ULL},
        {"/messages/1/uptime_ms", "soon"},
        {"/messages/1/time_ms", "2099-01-01"},
        {"/messages/1/historical", 1},
        {"/messages/1/status", json::array()},
        {"/messages/0/hello/capabilities", json{1}},
        {"/lost", json{{5, 3, 1}}},
        {"/lost", json(65, json{1, 2})},
        {status + "recording", 1},
        {status + "battery", 1.01},
        {status + "battery", "full"},
        {status + "depth_m", 1e9},
        {status + "num_frames", -1},
        {status + "leak", "no"},
        {status + "dive", std::string(65, 'x')},
        {status + "orientation", json{1, 0, 0}},
        {status + "errors", json{"a", 1}},
        {status + "errors", json(33, "e")},
        {status + "pictures", json{{"dark", 2.0}}},
        {status + "dive_plan", json::object()},
        {status + "dive_plan", json{{"back_in_s", -1}}},
    };
    for (const auto& [pointer, value] : bad) {
        const json report = with(pointer, value);
        EXPECT_FALSE(fits_schema(report)) << pointer << " " << value.dump().substr(0, 80);
        EXPECT_TRUE(fault_of(report).starts_with(pointer))
            << pointer << " " << value.dump().substr(0, 80) << ": " << fault_of(report);
    }
}

TEST(SensorReportTest, RefusesWhatASchemaCannotSay) {
    EXPECT_EQ(fault_of(with("/lost", json{{5, 3}})), "/lost");
    EXPECT_EQ(fault_of(with("/messages/1/status/orientation", json{1, 1, 0, 0})),
              "/messages/1/status/orientation");
    EXPECT_EQ(fault_of(with("/messages/1/status/vendor", std::string(20'000, 'v'))),
              "/messages/1/status");
}

TEST(SensorReportTest, TellsAllThatIsWrongAtOnce) {
    json report = with("/messages/1/status/battery", 7);
    report["messages"][1]["status"]["leak"] = 1;
    report["messages"][2]["seq"] = -3;
    try {
        sensor_report(report);
        FAIL();
    } catch (const InvalidInput& invalid) {
        EXPECT_EQ(invalid.faults().size(), 3U);
    }
}

TEST(SensorReportTest, TheSchemaHasEveryFieldWithItsRange) {
    const json fields = schema_document().at("definitions").at("status").at("properties");
    for (const StatusField& field : kStatusFields) {
        const json& described = fields.at(std::string(field.name));
        if (field.is_flag) {
            EXPECT_EQ(described.at("type").at(0), "boolean") << field.name;
            continue;
        }
        EXPECT_EQ(described.at("type").at(0), "number") << field.name;
        EXPECT_EQ(described.at("minimum").get<double>(), field.min) << field.name;
        EXPECT_EQ(described.at("maximum").get<double>(), field.max) << field.name;
    }
}

struct StatusAlarm {
    json status;
    std::string alarm;
    Summary summary;
};

TEST(SensorStatusTest, SaysWhatIsWrongAndHowBadThatIs) {
    const std::vector<StatusAlarm> cases = {
        {json::object(), "", Summary::Ok},
        {{{"battery", 0.9}, {"leak", false}, {"storage_free_bytes", 1e11}}, "", Summary::Ok},
        {{{"leak", true}}, "leak", Summary::Stop},
        {{{"humidity", 0.95}}, "leak", Summary::Attention},
        {{{"battery", 0.15}}, "battery", Summary::Attention},
        {{{"battery", 0.05}}, "battery", Summary::Stop},
        {{{"storage_free_bytes", 1e9}}, "storage", Summary::Attention},
        {{{"storage_free_bytes", 1e8}}, "storage", Summary::Stop},
        {{{"recording", false}}, "", Summary::Ok},
        {{{"recording", false}, {"dive", "wreck"}}, "recording", Summary::Stop},
        {{{"recording", true}, {"dive", "wreck"}}, "", Summary::Ok},
        {{{"pictures", {{"dark", 0.3}}}}, "pictures", Summary::Attention},
        {{{"pictures", {{"dark", 0.2}, {"frozen", 0.9}}}}, "pictures", Summary::Stop},
    };
    for (const auto& [status, alarm, summary] : cases) {
        const auto alarms = alarms_of(status);
        EXPECT_EQ(summary_of(alarms), summary) << status;
        EXPECT_EQ(alarms.empty() ? "" : alarms.at(0).name, alarm) << status;
    }
}

}  // namespace
}  // namespace divemesh
