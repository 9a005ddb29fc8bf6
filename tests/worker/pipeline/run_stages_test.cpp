#include "worker/pipeline/run_stages.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <set>

#include "tests/temporary_folder.hpp"
#include "worker/base/binary_file.hpp"
#include "worker/pipeline/stage_cache.hpp"

namespace divemesh::pipeline {
namespace {

namespace fs = std::filesystem;

using Names = std::vector<std::string>;

// The data passed between small stages: numbers, each computed from the previous one.
struct Numbers {
    fs::path scratch;
    ReconstructionOptions options;
    Names run = {};
    double root = 0.0;
    double square = 0.0;
    double sum = 0.0;
};

bool load_number(const fs::path& file, const std::string& key, double& number) {
    base::BinaryReader reader(file);
    if (!reader.ok() || reader.get_text() != key) return false;
    const auto stored = reader.get<double>();
    if (!reader.at_end()) return false;
    number = stored;
    return true;
}

void save_number(const fs::path& file, const std::string& key, double number) {
    base::BinaryWriter writer(file);
    writer.put_text(key);
    writer.put(number);
    writer.commit();
}

bool load_root(Numbers& numbers, const std::string& key) {
    return load_number(numbers.scratch / "root.stage", key, numbers.root);
}
void run_root(Numbers& numbers, const base::ProgressCallback& progress) {
    numbers.run.push_back("root");
    progress({.fraction = 0.5});
    numbers.root = numbers.options.num_features;
}
void save_root(Numbers& numbers, const std::string& key) {
    save_number(numbers.scratch / "root.stage", key, numbers.root);
}

bool load_sum(Numbers& numbers, const std::string& key) {
    return load_number(numbers.scratch / "sum.stage", key, numbers.sum);
}
void run_sum(Numbers& numbers, const base::ProgressCallback&) {
    numbers.run.push_back("sum");
    numbers.sum = numbers.root + numbers.square + numbers.options.voxel_m;
}
void save_sum(Numbers& numbers, const std::string& key) {
    save_number(numbers.scratch / "sum.stage", key, numbers.sum);
}

void run_tell(Numbers& numbers, const base::ProgressCallback&) { numbers.run.push_back("tell"); }

std::vector<Stage<Numbers>> small_stages() {
    return {{.spec = {.name = "root", .share = 0.5, .files = {"root.stage"}},
             .load = load_root,
             .run = run_root,
             .save = save_root},
            {.spec = {.name = "sum", .share = 0.2, .reads = {"voxel_m"}, .files = {"sum.stage"}},
             .load = load_sum,
             .run = run_sum,
             .save = save_sum},
            {.spec = {.name = "tell", .share = 0.1}, .run = run_tell}};
}

// An extra stage: one row, and the functions that it names.
bool square_wanted(const Numbers& numbers) { return numbers.options.surface; }
bool load_square(Numbers& numbers, const std::string& key) {
    return load_number(numbers.scratch / "squares/1.stage", key, numbers.square);
}
void run_square(Numbers& numbers, const base::ProgressCallback& progress) {
    numbers.run.push_back("square");
    progress({.fraction = 0.25});
    numbers.square = std::pow(numbers.root, 2) + numbers.options.simplify;
}
void save_square(Numbers& numbers, const std::string& key) {
    fs::create_directories(numbers.scratch / "squares");
    save_number(numbers.scratch / "squares/1.stage", key, numbers.square);
}

std::vector<Stage<Numbers>> stages_with_square() {
    auto stages = small_stages();
    stages.insert(
        stages.begin() + 1,
        {.spec = {.name = "square", .share = 0.2, .reads = {"simplify"}, .files = {"squares"}},
         .wanted = square_wanted,
         .load = load_square,
         .run = run_square,
         .save = save_square});
    return stages;
}

class RunStagesTest : public testing::Test {
protected:
    StageKeys keys(const nlohmann::json& overrides) const {
        return stage_keys(specs_of(stages_), "1.0", "dive", make_options("standard", overrides));
    }
    // Does one run in the folder `scratch`.
    Numbers run(const std::string& scratch, const nlohmann::json& overrides = kPlain) {
        fs::create_directories(folder_ / scratch);
        const ReconstructionOptions options = make_options("standard", overrides);
        const std::vector<StageSpec> specs = specs_of(stages_);
        Numbers numbers{.scratch = folder_ / scratch, .options = options};
        seen_.clear();
        reused_.clear();
        done_.clear();
        StageProgress progress([&](const Progress& at) { seen_.push_back(at); });
        run_stages(stages_,
                   numbers,
                   {.keys = keys(overrides),
                    .scratch = numbers.scratch,
                    .resumable = resumable_,
                    .store = *store_,
                    .progress = progress,
                    .begin =
                        [&](std::size_t index) {
                            numbers.options = options_known_to(index, specs, options);
                        },
                    .done =
                        [&](const StageSpec& stage, const StageTime& time) {
                            done_.push_back(stage.name);
                            EXPECT_EQ(time.stage, stage.name);
                            if (time.reused) reused_.push_back(time.stage);
                        }});
        progress.finish();
        return numbers;
    }
    // Returns the fraction of the whole run at which the stage began.
    double begin_of(const std::string& stage) const {
        for (const Progress& at : seen_)
            if (at.stage == stage) return at.fraction;
        return -1.0;
    }

    static inline const nlohmann::json kPlain = nlohmann::json::object();
    TemporaryFolder folder_;
    StageCache cache_{folder_ / "cache", 1'000'000};
    StageCache none_;
    StageStore* store_ = &cache_;
    bool resumable_ = true;
    std::vector<Stage<Numbers>> stages_ = stages_with_square();
    std::vector<Progress> seen_;
    Names reused_;
    Names done_;
};

TEST_F(RunStagesTest, AStageOfItsOwnRunsInItsPlaceAndIsLoadedTheSecondTime) {
    const Numbers first = run("first");
    EXPECT_EQ(first.run, (Names{"root", "square", "sum", "tell"}));
    EXPECT_EQ(first.sum, 300.0 + 90'001.0);
    EXPECT_TRUE(reused_.empty());

    const Numbers second = run("second");

    EXPECT_EQ(second.run, Names{"tell"});
    EXPECT_EQ(reused_, (Names{"root", "square", "sum"}));
    EXPECT_EQ(done_, (Names{"root", "square", "sum", "tell"}));
    EXPECT_EQ(second.square, first.square);
    EXPECT_EQ(second.sum, first.sum);
}

TEST_F(RunStagesTest, AnotherValueOfItsOptionMakesItAnewWithWhatFollows) {
    const StageKeys plain = keys(kPlain);
    const StageKeys half = keys({{"simplify", 0.5}});
    EXPECT_EQ(half.at("root"), plain.at("root"));
    EXPECT_NE(half.at("square"), plain.at("square"));
    EXPECT_NE(half.at("sum"), plain.at("sum"));

    run("first");
    const Numbers other = run("second", {{"simplify", 0.5}});

    EXPECT_EQ(other.run, (Names{"square", "sum", "tell"}));
    EXPECT_EQ(other.square, 90'000.5);
    EXPECT_EQ(run("third", {{"voxel_m", 0.5}}).run, (Names{"sum", "tell"}));
}

TEST_F(RunStagesTest, ProgressIsSharedAsTheTableSays) {
    run("first");

    EXPECT_DOUBLE_EQ(begin_of("root"), 0.0);
    EXPECT_DOUBLE_EQ(seen_.at(1).fraction, 0.25);  // half of the first half
    EXPECT_DOUBLE_EQ(begin_of("square"), 0.5);
    EXPECT_DOUBLE_EQ(begin_of("sum"), 0.7);
    EXPECT_DOUBLE_EQ(begin_of("tell"), 0.9);
    EXPECT_EQ(seen_.back().fraction, 1.0);
}

TEST_F(RunStagesTest, AStageThatIsNotWantedLeavesItsShareToTheOthers) {
    const Numbers without = run("first", {{"surface", false}});

    EXPECT_EQ(without.run, (Names{"root", "sum", "tell"}));
    EXPECT_EQ(done_, (Names{"root", "sum", "tell"}));
    EXPECT_DOUBLE_EQ(begin_of("sum"), 0.5 / 0.8);
    EXPECT_DOUBLE_EQ(begin_of("tell"), 0.7 / 0.8);
    EXPECT_EQ(seen_.back().fraction, 1.0);
}

TEST_F(RunStagesTest, AnOptionThatAStageIsTheFirstToReadDecidesWhetherItRuns) {
    stages_[1].wanted = [](const Numbers& numbers) { return numbers.options.simplify < 1.0; };

    EXPECT_EQ(run("first").run, (Names{"root", "sum", "tell"}));
    EXPECT_EQ(run("second", {{"simplify", 0.5}}).run, (Names{"square", "sum", "tell"}));
}

TEST_F(RunStagesTest, APartOfAStageIsToldAsThatStage) {
    stages_[1].spec.part_of = "root";
    run("first");

    EXPECT_EQ(begin_of("square"), -1.0);
    EXPECT_EQ(done_, (Names{"root", "square", "sum", "tell"}));
}

TEST_F(RunStagesTest, WithoutAStoreARunGoesOnFromWhatTheScratchFolderHolds) {
    store_ = &none_;
    run("scratch");
    fs::remove(folder_ / "scratch/sum.stage");

    EXPECT_EQ(run("scratch").run, (Names{"sum", "tell"}));
    EXPECT_EQ(run("elsewhere").run, (Names{"root", "square", "sum", "tell"}));
}

TEST_F(RunStagesTest, WhatAnotherRunLeftIsTakenAwayBeforeAStageIsMadeOrFetched) {
    run("first");
    for (const char* name : {"made", "fetched"}) {
        fs::create_directories(folder_ / name / "squares");
        std::ofstream(folder_ / name / "squares/stale") << "of another run";
        std::ofstream(folder_ / name / "squares/1.stage") << "half";
    }
    EXPECT_EQ(run("fetched").run, Names{"tell"});
    store_ = &none_;
    EXPECT_EQ(run("made").square, 90'001.0);

    EXPECT_FALSE(fs::exists(folder_ / "made/squares/stale"));
    EXPECT_FALSE(fs::exists(folder_ / "fetched/squares/stale"));
}

TEST_F(RunStagesTest, AnEntryThatCannotBeLoadedIsDroppedAndMadeAgain) {
    const std::string entry = "square-" + keys(kPlain).at("square");
    fs::create_directories(folder_ / "bad/squares");
    std::ofstream(folder_ / "bad/squares/1.stage") << "whole, but none of ours";
    cache_.store(entry, folder_ / "bad", {"squares"});

    EXPECT_EQ(run("first").run, (Names{"root", "square", "sum", "tell"}));
    EXPECT_EQ(run("second").run, Names{"tell"});
}

TEST_F(RunStagesTest, ARunThatIsNotResumableLeavesNothing) {
    resumable_ = false;
    run("first");

    EXPECT_TRUE(fs::is_empty(folder_ / "first"));
    EXPECT_TRUE(fs::is_empty(folder_ / "cache"));
}

}  // namespace
}  // namespace divemesh::pipeline
