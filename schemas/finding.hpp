#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace divemesh {

enum class Severity { Info, Warning, Error };

std::string_view to_string(Severity severity);
Severity severity_from_string(std::string_view text);  // throws Error{InvalidArgument}

// One observation about a dive, worded for the person who can act on it.
struct Finding {
    Severity severity = Severity::Info;
    std::string code;     // stable, for scripts: "cam1_missing", "imu_gap"
    std::string where;    // file, file:line or frame; "" for the dive as a whole
    std::string message;  // what was seen, with numbers
    std::string remedy;   // what to do; "" if no action is needed
};

// An error refuses the dive; other findings let it run.
bool has_error(const std::vector<Finding>& findings);

}  // namespace divemesh
