#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "schemas/job.hpp"

namespace divemesh {

// A job as the API shows it, with what is known only on request.
struct ShownJob : Job {
    // Why it waits although it may be its turn: a word of WaitReason, or of a newer version. Empty
    // if nothing but the jobs before it keeps it waiting.
    std::string waits_for;
    std::int64_t deleted_at_ms = 0;  // of its result; 0: it is not deleted
    std::int64_t expires_at_ms = 0;  // when the result is removed for good
};

void to_json(nlohmann::json& json, const ShownJob& job);
void from_json(const nlohmann::json& json, ShownJob& job);

}  // namespace divemesh
