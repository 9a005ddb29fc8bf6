#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "schemas/finding.hpp"
#include "schemas/verdict.hpp"

namespace divemesh {

// A metric as a job measured it, see schemas/metric.hpp for the names.
struct MeasuredMetric {
    std::string name;
    double value = 0.0;
    std::string unit;
    std::string method;
};

// A requirement of a report, and whether it is met.
struct RequirementResult {
    std::string text;             // as written: "drift_percent<=0.5"
    std::string metric;           // its full name
    std::optional<double> value;  // nullopt: there is no such metric, so it is not met
    bool met = false;
    std::string reason;  // why it is not met; "" if it is
};

// A metric that is worse than its earlier values allow.
struct Regression {
    std::string metric;
    double value = 0.0;
    double median = 0.0;  // of the earlier values
    double limit = 0.0;   // that the earlier values allow
    std::int64_t num_earlier = 0;
};

// What a job measured, stored when it succeeds; of a reconstruction that is not usable, findings
// and verdict are stored when it fails.
struct Measurement {
    std::vector<MeasuredMetric> metrics;
    std::vector<RequirementResult> requirements;  // of a report
    std::vector<Regression> regressions;          // of a report
    std::string version;                          // of the program that measured
    std::string calibration_sha256;
    std::vector<Finding> findings;   // of a reconstruction
    std::optional<Verdict> verdict;  // of a reconstruction
};

// One value of a series over dives and time.
struct MetricPoint {
    std::int64_t number = 0;  // rises with time; not shown over HTTP
    std::string dive_id;
    std::string job_id;
    std::string kind;  // of the job
    std::string site;
    std::string rig;
    std::string preset;
    std::string version;
    std::string calibration_sha256;
    std::int64_t time_ms = 0;
    double value = 0.0;
};

}  // namespace divemesh
