#include "schemas/truth_options.hpp"

#include <charconv>
#include <cmath>
#include <string>
#include <vector>

namespace divemesh {
namespace {

[[noreturn]] void refuse(const std::string& option, std::string_view text, const std::string& how) {
    throw Error(
        ErrorCode::InvalidArgument,
        std::string(option).append(" '").append(text.substr(0, 120)).append("': give " + how));
}

// Returns comma-separated numbers; nullopt if one is invalid.
std::optional<std::vector<double>> numbers_of(std::string_view text) {
    std::vector<double> numbers;
    while (true) {
        while (text.starts_with(' ')) text.remove_prefix(1);
        double number = 0.0;
        const auto [end, code] = std::from_chars(text.data(), text.data() + text.size(), number);
        if (code != std::errc() || !std::isfinite(number)) return std::nullopt;
        numbers.push_back(number);
        text.remove_prefix(static_cast<std::size_t>(end - text.data()));
        while (text.starts_with(' ')) text.remove_prefix(1);
        if (text.empty()) return numbers;
        if (!text.starts_with(',')) return std::nullopt;
        text.remove_prefix(1);
    }
}

}  // namespace

void set_lever_arm(TruthOptions& options, std::string_view text) {
    constexpr double kMaxLength_m = 100.0;
    options.solve_lever_arm = text == "solve";
    options.lever_arm.reset();
    if (options.solve_lever_arm) return;
    const auto v = numbers_of(text);
    const bool has_form = v && (v->size() == 3 || v->size() == 7);
    if (!has_form || std::hypot((*v)[0], (*v)[1], (*v)[2]) > kMaxLength_m)
        refuse("lever arm", text, "solve, x,y,z or x,y,z,qw,qx,qy,qz (m, from the rig's body)");
    TruthOptions::LeverArm arm;
    arm.position_m = {(*v)[0], (*v)[1], (*v)[2]};
    if (v->size() == 7) {
        const double norm = std::hypot(std::hypot((*v)[3], (*v)[4]), std::hypot((*v)[5], (*v)[6]));
        if (std::abs(norm - 1.0) > 0.02) refuse("lever arm", text, "a quaternion of length 1");
        for (std::size_t i = 0; i < 4; ++i) arm.orientation_wxyz[i] = (*v)[3 + i] / norm;
    }
    options.lever_arm = arm;
}

void set_time_offset(TruthOptions& options, std::string_view text) {
    constexpr double kMaxOffset_s = 4e9;  // unix time against a clock that starts at zero
    options.solve_time_offset = text == "solve";
    options.time_offset_s = 0.0;
    if (options.solve_time_offset) return;
    const auto v = numbers_of(text);
    if (!v || v->size() != 1 || std::abs(v->front()) > kMaxOffset_s)
        refuse("time offset", text, "solve, or seconds (the truth's clock minus the dive's)");
    options.time_offset_s = v->front();
}

}  // namespace divemesh
