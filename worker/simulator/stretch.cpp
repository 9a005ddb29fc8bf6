#include "worker/simulator/stretch.hpp"

#include <algorithm>
#include <sstream>

#include "schemas/error.hpp"

namespace divemesh::simulator {
namespace {

constexpr double kMaxDuration_s = 3600.0;

bool is_possible(const Stretch& stretch) {
    return stretch.at_share >= 0.0 && stretch.at_share <= 1.0 && stretch.duration_s > 0.0 &&
           stretch.duration_s <= kMaxDuration_s;
}

Stretch stretch_from_string(const std::string& text) {
    std::istringstream in(text);
    Stretch stretch;
    char colon = 0;
    if (in >> stretch.at_share >> colon >> stretch.duration_s && colon == ':' &&
        in.peek() == std::istringstream::traits_type::eof() && is_possible(stretch))
        return stretch;
    throw Error(ErrorCode::InvalidArgument,
                "\"" + text +
                    "\" is no stretch of a dive: write where it begins as a share from 0 to 1, a "
                    "colon and its seconds, for example 0.5:10");
}

bool begins_earlier(const Stretch& a, const Stretch& b) { return a.at_share < b.at_share; }

}  // namespace

std::vector<Stretch> stretches_from_string(const std::string& text) {
    std::vector<Stretch> stretches;
    std::istringstream items(text);
    for (std::string item; std::getline(items, item, ',');)
        stretches.push_back(stretch_from_string(item));
    if (!std::is_sorted(stretches.begin(), stretches.end(), begins_earlier))
        throw Error(ErrorCode::InvalidArgument,
                    "the stretches \"" + text + "\" are out of order: begin with the earliest");
    return stretches;
}

}  // namespace divemesh::simulator
