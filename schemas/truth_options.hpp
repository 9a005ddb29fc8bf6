#pragma once

#include <array>
#include <optional>
#include <string_view>

#include "schemas/error.hpp"

namespace divemesh {

// How a truth of another body and clock, e.g. from an external tracker, relates to the dive.
struct TruthOptions {
    // The tracked point on the rig's body: T_body_marker. nullopt: the body itself.
    struct LeverArm {
        std::array<double, 3> position_m = {0.0, 0.0, 0.0};
        std::array<double, 4> orientation_wxyz = {1.0, 0.0, 0.0, 0.0};
    };
    std::optional<LeverArm> lever_arm;
    bool solve_lever_arm = false;
    double time_offset_s = 0.0;  // the truth's clock minus the dive's
    bool solve_time_offset = false;
};

// Parses "solve", or "x,y,z" in m, or "x,y,z,qw,qx,qy,qz". Throws Error{InvalidArgument}.
void set_lever_arm(TruthOptions& options, std::string_view text);

// Parses "solve", or seconds. Throws Error{InvalidArgument}.
void set_time_offset(TruthOptions& options, std::string_view text);

}  // namespace divemesh
