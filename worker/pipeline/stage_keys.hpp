#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "schemas/reconstruction_options.hpp"
#include "worker/pipeline/stage.hpp"

namespace divemesh::pipeline {

// The options that change no byte of any result: no stage's key has them.
inline constexpr std::string_view kOptionsOfTheMachine[] = {"num_threads", "fusion_memory_bytes"};

// By the stage's name.
using StageKeys = std::map<std::string, std::string>;

// What the result of each stage depends on: the dive, the program, and the options that this stage
// or one before it reads. Two runs whose keys are equal make the same bytes; a run that differs in
// an option starts at the stage that reads it first. An option that no stage names counts as read
// by the first one: forgotten, it costs time, never a wrong result.
StageKeys stage_keys(const std::vector<StageSpec>& stages,
                     const std::string& program,
                     const std::string& content_sha256,
                     const ReconstructionOptions& options);

}  // namespace divemesh::pipeline
