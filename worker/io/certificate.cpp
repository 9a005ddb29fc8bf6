#include "worker/io/certificate.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <string_view>

#include "schemas/error.hpp"
#include "worker/base/text.hpp"

namespace divemesh::io {
namespace {

using nlohmann::json;

// Metrics that say how good a result is: what it expects of itself, then its error against a truth
// if the dive has one.
constexpr std::array<std::string_view, 15> kAccuracy = {
    "frames.coverage",
    "calibration.scale_sigma",
    "calibration.scale_contradiction",
    "mesh.simplification.rms_m",
    "expected_accuracy.level",
    "expected_accuracy.trajectory.ate.bound_m",
    "expected_accuracy.trajectory.end_position.bound_m",
    "expected_accuracy.surface.sigma_median_m",
    "expected_accuracy.surface.error_95_m",
    "trajectory.final.ate_rmse_m",
    "trajectory.final.drift_percent",
    "surface.accuracy.median_m",
    "surface.accuracy.p90_m",
    "known_distances.scale_error",
    "known_distances.rmse_m",
};

constexpr std::size_t kMaxLineLetters = 400;

json::json_pointer pointer_of(std::string_view metric) {
    std::string path = "/" + std::string(metric);
    std::replace(path.begin(), path.end(), '.', '/');
    return json::json_pointer(path);
}

[[noreturn]] void fail(const std::string& where, const std::string& what) {
    throw Error(ErrorCode::BadData,
                "metrics.json, " + where + ": " + what +
                    ": use the file as `divemesh reconstruct` wrote it");
}

// Copies a field to the same place, unless metrics.json has no value of it.
template <typename Type>
void copy(const json& metrics, std::string_view name, json& certificate) {
    const json::json_pointer pointer = pointer_of(name);
    if (!metrics.contains(pointer) || metrics.at(pointer).is_null()) return;
    const json& value = metrics.at(pointer);
    const bool fits = std::is_same_v<Type, double> ? value.is_number() : value.is_string();
    if (!fits)
        fail(std::string(name), std::is_same_v<Type, double> ? "not a number" : "not a text");
    certificate[pointer] = value;
}

json accuracy(const json& metrics) {
    json result = json::object();
    for (const std::string_view name : kAccuracy) {
        json copied = json::object();
        copy<double>(metrics, name, copied);
        if (!copied.empty()) result[std::string(name)] = copied.at(pointer_of(name));
    }
    return result;
}

// Returns the options without what changes the run alone.
json options(const json& metrics) {
    json result = metrics.at("options");
    if (!result.is_object()) fail("options", "not an object");
    result.erase("num_threads");
    return result;
}

// Returns severity and code of the findings, each pair once, in their order.
json codes(const json& findings) {
    json result = json::array();
    for (const json& finding : findings) {
        const json code = {{"severity", finding.at("severity").get<std::string>()},
                           {"code", finding.at("code").get<std::string>()}};
        if (std::find(result.begin(), result.end(), code) == result.end()) result.push_back(code);
    }
    return result;
}

std::string utc_text(std::chrono::sys_seconds time) {
    const auto day = std::chrono::floor<std::chrono::days>(time);
    const std::chrono::year_month_day date(day);
    const std::chrono::hh_mm_ss clock(time - day);
    char text[64];
    std::snprintf(text,
                  sizeof text,
                  "%04d-%02u-%02uT%02d:%02d:%02dZ",
                  static_cast<int>(date.year()),
                  static_cast<unsigned>(date.month()),
                  static_cast<unsigned>(date.day()),
                  static_cast<int>(clock.hours().count()),
                  static_cast<int>(clock.minutes().count()),
                  static_cast<int>(clock.seconds().count()));
    return text;
}

std::string verdict_text(const json& certificate) {
    std::string text = certificate.value("verdict", "not stated");
    std::replace(text.begin(), text.end(), '_', ' ');
    std::string separator = ": ";
    for (const json& part : certificate.value("restrictions", json::array())) {
        text += separator + part.get<std::string>();
        separator = ", ";
    }
    return text;
}

// Appends a metric in words, with its value multiplied by `unit`; appends nothing if it is unknown.
void append(std::string& line,
            const json& certificate,
            const char* metric,
            const std::string& words,
            double unit,
            const std::string& unit_words) {
    const json& known = certificate.at("accuracy");
    if (!known.contains(metric)) return;
    line += "; " + words + " " + base::significant(unit * known.at(metric).get<double>(), 3) +
            unit_words;
}

std::string printable(std::string line) {
    for (char& letter : line)
        if (letter < ' ' || letter > '~') letter = '?';
    return line.substr(0, kMaxLineLetters);
}

}  // namespace

std::optional<std::chrono::sys_seconds> recording_begin(const json& metrics) try {
    constexpr std::int64_t kNsPerSecond = 1'000'000'000;
    constexpr std::int64_t kYear2000_s = 946'684'800;  // clocks that were never set begin earlier
    std::optional<std::int64_t> first_ns;
    for (const json& segment : metrics.value("pieces", json::array()))
        for (const json& interval : segment.value("intervals", json::array())) {
            const auto ns = interval.at("first_ns").get<std::int64_t>();
            first_ns = std::min(first_ns.value_or(ns), ns);
        }
    if (!first_ns || *first_ns / kNsPerSecond < kYear2000_s) return std::nullopt;
    return std::chrono::sys_seconds(std::chrono::seconds(*first_ns / kNsPerSecond));
} catch (const json::exception& error) {
    fail("pieces", error.what());
}

json certificate_of(const json& metrics) try {
    json certificate = {{"format", 1}};
    for (const char* name :
         {"version", "preset", "verdict", "dive.name", "dive.content_sha256", "calibration.sha256"})
        copy<std::string>(metrics, name, certificate);
    for (const char* name : {"dive.duration_s",
                             "dive.position.latitude_deg",
                             "dive.position.longitude_deg",
                             "dive.position.x_azimuth_deg"})
        copy<double>(metrics, name, certificate);
    if (const auto begin = recording_begin(metrics))
        certificate["dive"]["recorded_utc"] = utc_text(*begin);
    if (metrics.contains("options")) certificate["options"] = options(metrics);
    certificate["accuracy"] = accuracy(metrics);
    if (metrics.contains("restrictions"))
        certificate["restrictions"] = metrics.at("restrictions").get<std::vector<std::string>>();
    if (metrics.contains("findings")) certificate["findings"] = codes(metrics.at("findings"));
    return certificate;
} catch (const json::exception& error) {
    fail("findings or restrictions", error.what());
}

std::string certificate_line(const json& certificate) {
    std::string line = "divemesh " + certificate.value("version", "of an older version") +
                       "; verdict: " + verdict_text(certificate);
    const auto add = [&](auto... arguments) { append(line, certificate, arguments...); };
    add("calibration.scale_sigma", "scale", 100.0, " % (1 sigma)");
    add("expected_accuracy.surface.sigma_median_m", "surface", 1e3, " mm (median sigma)");
    add("expected_accuracy.trajectory.ate.bound_m", "path within", 1e3, " mm (95 %)");
    add("trajectory.final.ate_rmse_m", "path against truth", 1e3, " mm RMSE");
    add("surface.accuracy.median_m", "surface against truth", 1e3, " mm median");
    const std::string hash = certificate.value(json::json_pointer("/dive/content_sha256"), "");
    if (!hash.empty()) line += "; dive " + hash.substr(0, 12);
    return printable(line);
}

}  // namespace divemesh::io
