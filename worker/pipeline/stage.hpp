#pragma once

#include <string>
#include <vector>

#include "schemas/reconstruction_options.hpp"
#include "worker/base/observer.hpp"

namespace divemesh::pipeline {

// What is known of a stage before it runs.
struct StageSpec {
    std::string name;  // in metrics.json, in progress and among the stages of a job
    // The stage that progress names in place of this one, which is then no stage of a job; empty:
    // this one stands for itself.
    std::string part_of = {};
    double share = 0.0;  // of the progress, where every stage runs
    // The options that no stage before this one reads: with another value the run starts here.
    std::vector<std::string> reads = {};
    // Whether these options change what is made; null: they do.
    bool (*reads_count)(const ReconstructionOptions& options) = nullptr;
    // What it leaves in the scratch folder, files and folders: an entry of the stage store.
    std::vector<std::string> files = {};
};

// One stage of a run: a row of the table of stages. `State` is what the stages hand on.
template <typename State>
struct Stage {
    StageSpec spec;
    // Whether there is anything to do; null: always.
    bool (*wanted)(const State& state) = nullptr;
    // Reads what the stage left in the scratch folder. Returns false when it is not there whole or
    // was made from something else than `key` stands for. Null: the stage always runs.
    bool (*load)(State& state, const std::string& key) = nullptr;
    void (*run)(State& state, const base::ProgressCallback& progress) = nullptr;
    // Writes `spec.files`, the one that carries `key` last. Null where `load` is.
    void (*save)(State& state, const std::string& key) = nullptr;
    // What follows from the result, loaded or made; null: nothing does.
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
