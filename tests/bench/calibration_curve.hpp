#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace divemesh::bench {

// How often what was stated came true, over many dives. A sample is the level at which a bound
// would just have held: 0.5 when the error was the median of what was expected.
class CalibrationCurve {
public:
    explicit CalibrationCurve(std::string kind) : kind_(std::move(kind)) {}

    // One dive, one error.
    void add(double just_held) { dives_.push_back({{just_held}}); }
    // One dive with many errors that share a part: it counts as one sample, by shares.
    void add(std::vector<double> just_held);

    const std::string& kind() const { return kind_; }
    std::size_t num_dives() const { return dives_.size(); }
    // Mean over the dives of the share of their errors within the bound of this level.
    double held(double level) const;
    nlohmann::json to_json() const;

private:
    std::string kind_;
    std::vector<std::vector<double>> dives_;  // sorted
};

// Levels at which the curves are shown.
const std::vector<double>& shown_levels();

// Returns the level of an error whose standard deviation is stated.
double level_of_normal(double error, double sigma);
// Returns the level of a length whose root mean square and 95 % bound are stated: by the chi-square
// distribution that has both.
double level_of_length(double length, double root_mean_square, double bound_95);

}  // namespace divemesh::bench
