#include "worker/pipeline/build_id.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <memory>

namespace divemesh::pipeline {
namespace {

// Returns the build id that binutils reads from this program.
std::string as_readelf_says() {
    const std::unique_ptr<FILE, int (*)(FILE*)> output(
        popen("readelf -n /proc/$PPID/exe 2>/dev/null | sed -n 's/.*Build ID: //p'", "r"), pclose);
    std::array<char, 128> line{};
    if (!output || fgets(line.data(), line.size(), output.get()) == nullptr) return "";
    std::string text = line.data();
    if (text.ends_with('\n')) text.pop_back();
    return text;
}

TEST(BuildIdTest, IsThatOfTheProgram) {
    const std::string expected = as_readelf_says();
    if (expected.empty()) GTEST_SKIP() << "no readelf";
    EXPECT_EQ(build_id(), expected);
}

}  // namespace
}  // namespace divemesh::pipeline
