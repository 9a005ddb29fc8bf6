#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace divemesh::bench {

// The observed coverage of stated bounds over many dives. A sample is the lowest confidence level
// whose bound holds the error: 0.5 when the error equals the expected median.
class CalibrationCurve {
public:
    explicit CalibrationCurve(std::string kind) : kind_(std::move(kind)) {}

    // Adds a dive with one error.
    void add(double just_held) { dives_.push_back({{just_held}}); }
    // Adds a dive with many errors. They have a part in common, so the dive counts as one sample
    // and each error as an equal share of it.
    void add(std::vector<double> just_held);

    const std::string& kind() const { return kind_; }
    std::size_t num_dives() const { return dives_.size(); }
    // Returns the share of a dive's errors within the bound of this level, averaged over the dives.
    double held(double level) const;
    nlohmann::json to_json() const;

private:
    std::string kind_;
    std::vector<std::vector<double>> dives_;  // sorted
};

// Returns the levels at which to_json() writes a curve.
const std::vector<double>& shown_levels();

// Returns the level of a normally distributed error with standard deviation `sigma`.
double level_of_normal(double error, double sigma);
// Returns the level of a length, by the chi-square distribution that fits its stated root mean
// square and 95 % bound.
double level_of_length(double length, double root_mean_square, double bound_95);

}  // namespace divemesh::bench
