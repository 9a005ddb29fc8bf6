#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "schemas/job.hpp"

namespace divemesh {

// A job as the API shows it, with what is known only on request.
struct ShownJob : Job {
    // Why it waits although it may be its turn: a word of WaitReason, or of a newer version; "":
    // for nothing else.
    std::string waits_for;
};

void to_json(nlohmann::json& json, const ShownJob& job);
void from_json(const nlohmann::json& json, ShownJob& job);

}  // namespace divemesh
