#include "tests/bench/kept_results.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/temporary_folder.hpp"

namespace divemesh::bench {
namespace {

using nlohmann::json;

class KeptResultsTest : public testing::Test {
protected:
    void SetUp() override { write(program_, "one"); }

    static void write(const std::filesystem::path& file, const std::string& text) {
        std::ofstream(file) << text;
    }

    const TemporaryFolder folder_;
    const std::filesystem::path program_ = folder_ / "program";
    const json result_ = {{"metrics", {{"ate_rmse_m", 0.001}}}};
};

TEST_F(KeptResultsTest, WhatWasKeptIsFoundByAnotherRunOfTheSameProgram) {
    KeptResults(folder_.path(), program_).keep("tank", result_);
    EXPECT_EQ(KeptResults(folder_.path(), program_).find("tank"), result_);
    EXPECT_FALSE(KeptResults(folder_.path(), program_).find("barge"));
}

TEST_F(KeptResultsTest, TheResultOfAnotherProgramIsNotFound) {
    KeptResults(folder_.path(), program_).keep("tank", result_);
    write(program_, "two");
    EXPECT_FALSE(KeptResults(folder_.path(), program_).find("tank"));
}

TEST_F(KeptResultsTest, AFileCutShortIsNoResult) {
    const KeptResults kept(folder_.path(), program_);
    kept.keep("tank", result_);
    write(folder_ / "tank.json", "{\"program_sha256\": \"");
    EXPECT_FALSE(kept.find("tank"));
}

}  // namespace
}  // namespace divemesh::bench
