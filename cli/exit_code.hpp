#pragma once

#include "schemas/error.hpp"

namespace divemesh::cli {

inline constexpr int kExitDone = 0;
inline constexpr int kExitFailed = 1;            // the work failed
inline constexpr int kExitUsage = 2;             // the command line is wrong
inline constexpr int kExitRequirementUnmet = 3;  // a stated requirement is not met

constexpr int exit_code_of(ErrorCode code) {
    return code == ErrorCode::InvalidArgument ? kExitUsage : kExitFailed;
}

}  // namespace divemesh::cli
