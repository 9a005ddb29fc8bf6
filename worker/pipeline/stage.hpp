#pragma once

#include <string>
#include <vector>

#include "schemas/reconstruction_options.hpp"
#include "worker/base/observer.hpp"

namespace divemesh::pipeline {

// The description of a stage, known before it runs.
struct StageSpec {
    std::string name;  // in metrics.json, in progress and among the stages of a job
    // The stage that progress reports instead of this one, which is then not listed among the
    // stages of a job; empty: this stage itself.
    std::string part_of = {};
    double share = 0.0;  // of the progress if every stage runs; the shares of a table sum to 1
    // The options that this stage is the first to read: a run with another value starts here.
    std::vector<std::string> reads = {};
    // Returns true if the `reads` options affect the result; null: they always do. Returns false
    // for an option that only decides whether the stage runs: later stages then stay as they are.
    bool (*reads_count)(const ReconstructionOptions& options) = nullptr;
    // It judges the result instead of making it: its time is not in the speed of the pipeline.
    bool is_evaluation = false;
    // Its files and folders in the scratch folder: an entry of the stage store.
    std::vector<std::string> files = {};
};

// One stage of a run: a row of the table of stages. `State` is what the stages share.
template <typename State>
struct Stage {
    StageSpec spec;
    // Returns true if the stage is to run; null: always.
    bool (*wanted)(const State& state) = nullptr;
    // Reads what the stage left in the scratch folder. Returns false if it is missing, incomplete,
    // or was made for another key. Null: the stage always runs.
    bool (*load)(State& state, const std::string& key) = nullptr;
    void (*run)(State& state, const base::ProgressCallback& progress) = nullptr;
    // Writes those of `spec.files` that run() has not written, the one with `key` last. Null if
    // `load` is null.
    void (*save)(State& state, const std::string& key) = nullptr;
    // Runs after the result was loaded or made; null: not needed.
    void (*finish)(State& state) = nullptr;
};

template <typename State>
std::vector<StageSpec> specs_of(const std::vector<Stage<State>>& stages) {
    std::vector<StageSpec> specs;
    specs.reserve(stages.size());
    for (const Stage<State>& stage : stages) specs.push_back(stage.spec);
    return specs;
}

}  // namespace divemesh::pipeline
