#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace divemesh {

// Which values of a metric are better; None: they are properties, as a length is.
enum class BetterValue { Lower, Higher, None };

std::string_view to_string(BetterValue better);

// Returns which values of this metric are better. Properties of a dive (its length, its
// calibration, the number of keyframes) are not judged, and its speed depends on the machine.
BetterValue better_value(const std::string& metric_name);

// A metric that the schemas describe.
struct KnownMetric {
    std::string name;  // [*] stands for any entry of a list, .* at its end for any metric below
    std::string unit;  // "1": dimensionless; "": that of the metric below
    BetterValue better = BetterValue::None;
    std::string method;
};

// Returns all of them, by name.
std::vector<KnownMetric> known_metrics();

}  // namespace divemesh
