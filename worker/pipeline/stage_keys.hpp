#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "schemas/reconstruction_options.hpp"
#include "worker/pipeline/stage.hpp"

namespace divemesh::pipeline {

// The options that do not change any result; they are in no stage's key.
inline constexpr std::string_view kOptionsOfTheMachine[] = {"num_threads", "fusion_memory_bytes"};

// Keys by the stage's name.
using StageKeys = std::map<std::string, std::string>;

// Returns a key of everything that each stage's result depends on: the dive, the program, and the
// options that this stage or an earlier one reads. Two runs with equal keys make the same bytes. A
// run with another option starts at the first stage that reads it. An option that no stage names
// counts as read by the first one: forgetting it costs time, but never gives a wrong result.
StageKeys stage_keys(const std::vector<StageSpec>& stages,
                     const std::string& program,
                     const std::string& content_sha256,
                     const ReconstructionOptions& options);

// Returns the options as the stage at `index` may read them: those that only a later stage names
// have their default. A stage that reads one of them too early thus ignores it, and never makes a
// result that depends on what its key does not hold.
ReconstructionOptions options_known_to(std::size_t index,
                                       const std::vector<StageSpec>& stages,
                                       const ReconstructionOptions& options);

}  // namespace divemesh::pipeline
