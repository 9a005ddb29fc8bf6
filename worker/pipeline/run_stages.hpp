#pragma once

#include <cstddef>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "worker/pipeline/stage.hpp"
#include "worker/pipeline/stage_keys.hpp"
#include "worker/pipeline/stage_progress.hpp"
#include "worker/pipeline/stage_store.hpp"
#include "worker/pipeline/stage_time.hpp"

namespace divemesh::pipeline {

// The settings and callbacks of a run of stages.
struct StageRunSettings {
    StageKeys keys;
    std::filesystem::path scratch;  // files for the next stages and for another run
    bool resumable = true;          // whether stages save their results there
    StageStore& store;
    StageProgress& progress;
    std::function<void(std::size_t index)> begin = [](std::size_t) {};
    std::function<void(const StageSpec&, const StageTime&)> done;
};

// Returns the name of a stage's entry in the store.
inline std::string entry_name(const StageSpec& stage, const StageKeys& keys) {
    return stage.name + "-" + keys.at(stage.name);
}

// Removes the stage's files: they may be incomplete, from another entry, or links into the store.
inline void clear_files(const StageSpec& stage, const std::filesystem::path& scratch) {
    for (const std::string& name : stage.files) std::filesystem::remove_all(scratch / name);
}

// Loads the result of a stage, left by an earlier attempt or taken from the store. Returns false if
// there is none.
template <typename State>
bool load_stage(const Stage<State>& stage, State& state, const StageRunSettings& settings) {
    if (stage.load == nullptr) return false;
    const std::string& key = settings.keys.at(stage.spec.name);
    if (stage.load(state, key)) return true;
    clear_files(stage.spec, settings.scratch);
    const std::string entry = entry_name(stage.spec, settings.keys);
    if (!settings.store.fetch(entry, settings.scratch)) return false;
    if (stage.load(state, key)) return true;
    settings.store.drop(entry);
    return false;
}

template <typename State>
void make_stage(const Stage<State>& stage,
                State& state,
                const StageRunSettings& settings,
                const base::ProgressCallback& progress) {
    clear_files(stage.spec, settings.scratch);
    stage.run(state, progress);
    if (stage.save == nullptr || !settings.resumable) return;
    stage.save(state, settings.keys.at(stage.spec.name));
    settings.store.store(entry_name(stage.spec, settings.keys), settings.scratch, stage.spec.files);
}

// Runs the wanted stages in order; a stage is loaded if its result exists. Progress is divided
// among the wanted stages in the proportions of the table.
template <typename State>
void run_stages(const std::vector<Stage<State>>& stages,
                State& state,
                const StageRunSettings& settings) {
    const auto wanted = [&](const Stage<State>& stage) {
        return stage.wanted == nullptr || stage.wanted(state);
    };
    double whole = 0.0;
    for (const Stage<State>& stage : stages) whole += wanted(stage) ? stage.spec.share : 0.0;
    for (std::size_t i = 0; i < stages.size(); ++i) {
        const Stage<State>& stage = stages[i];
        settings.begin(i);  // before `wanted`, which may ask for the stage's own options
        if (!wanted(stage)) continue;
        const StageSpec& spec = stage.spec;
        const Stopwatch watch;
        const auto progress = settings.progress.begin(
            spec.part_of.empty() ? spec.name : spec.part_of, spec.share / whole);
        const bool reused = load_stage(stage, state, settings);
        if (!reused) make_stage(stage, state, settings, progress);
        if (stage.finish != nullptr) stage.finish(state);
        StageTime time = watch.stop(spec.name);
        time.reused = reused;
        time.is_evaluation = spec.is_evaluation;
        settings.done(spec, time);
    }
}

}  // namespace divemesh::pipeline
