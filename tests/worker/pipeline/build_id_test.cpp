#include "worker/pipeline/build_id.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

namespace divemesh::pipeline {
namespace {

// Returns the build ids that binutils reads from the files that `list` names, a shell command.
std::vector<std::string> as_readelf_says(const std::string& list) {
    const std::string command =
        list + " | xargs readelf -n 2>/dev/null | sed -n 's/.*Build ID: //p'";
    const std::unique_ptr<FILE, int (*)(FILE*)> output(popen(command.c_str(), "r"), pclose);
    std::vector<std::string> ids;
    std::array<char, 128> line{};
    while (output && fgets(line.data(), line.size(), output.get()) != nullptr) {
        ids.emplace_back(line.data());
        if (ids.back().ends_with('\n')) ids.back().pop_back();
    }
    return ids;
}

TEST(BuildIdTest, BeginsWithThatOfTheProgram) {
    const auto program = as_readelf_says("echo /proc/$PPID/exe");
    if (program.empty()) GTEST_SKIP() << "no readelf";
    ASSERT_EQ(program.size(), 1U);
    EXPECT_TRUE(build_id().starts_with(program[0])) << build_id();
}

TEST(BuildIdTest, HoldsThatOfEverySharedLibrary) {
    const auto libraries =
        as_readelf_says("sed -n 's|.* \\(/.*\\.so[.0-9]*\\)$|\\1|p' /proc/$PPID/maps | sort -u");
    if (libraries.empty()) GTEST_SKIP() << "no readelf";
    EXPECT_GT(libraries.size(), 3U);
    for (const std::string& id : libraries) EXPECT_NE(build_id().find(id), std::string::npos) << id;
}

}  // namespace
}  // namespace divemesh::pipeline
