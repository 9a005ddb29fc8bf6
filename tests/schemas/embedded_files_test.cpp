#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "schemas/embedded_schemas.hpp"
#include "tests/paths.hpp"
#include "tests/schemas/awkward_text.hpp"

namespace divemesh {
namespace {

std::string bytes_of(const std::filesystem::path& file) {
    std::ostringstream bytes;
    bytes << std::ifstream(source_directory() / file, std::ios::binary).rdbuf();
    return bytes.str();
}

TEST(EmbeddedFiles, AreTheirFilesByteForByte) {
    const std::string schema = bytes_of("schemas/metrics.schema.json");
    ASSERT_FALSE(schema.empty());
    EXPECT_EQ(metrics_schema_json(), schema);
}

TEST(EmbeddedFiles, WhatCMakeOrCxxCouldTakeForTheirsIsKept) {
    const std::string text = bytes_of("tests/schemas/awkward.txt");
    ASSERT_NE(text.find(")\"b R\"(c)\" ]] [[ a;b;;c ${HOME} @ROOT@"), std::string::npos);
    EXPECT_EQ(awkward_txt(), text);
}

}  // namespace
}  // namespace divemesh
