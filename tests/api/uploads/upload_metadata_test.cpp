#include "api/uploads/upload_metadata.hpp"

#include <gtest/gtest.h>

#include "schemas/error.hpp"

namespace divemesh::api {
namespace {

TEST(UploadMetadataTest, ReadsPairsAndKeysWithoutValue) {
    const auto metadata = parse_upload_metadata("filename d3JlY2suemlw, job c3RhbmRhcmQ=,empty");
    EXPECT_EQ(metadata.at("filename"), "wreck.zip");
    EXPECT_EQ(metadata.at("job"), "standard");
    EXPECT_EQ(metadata.at("empty"), "");
    EXPECT_TRUE(parse_upload_metadata("").empty());
    EXPECT_TRUE(parse_upload_metadata("  ").empty());
}

TEST(UploadMetadataTest, RefusesWhatTusDoesNotAllow) {
    for (const char* header : {"a YQ==,a YQ==",
                               "a YQ==,,b YQ==",
                               ",",
                               "a YQ==,",
                               "a Y",
                               "a YQ=",
                               "a Y=Q=",
                               "a ====",
                               "a YQ==YQ==",
                               "a Y Q==",
                               "a YQ-_",
                               "k\xc3\xa9y YQ=="})
        EXPECT_THROW(parse_upload_metadata(header), Error) << header;
}

TEST(UploadMetadataTest, TakesTheNameWithoutFoldersAndControlCharacters) {
    EXPECT_EQ(plan_of("filename Li4vLi4vZXRjL3Bhc3N3ZA==").name, "passwd");  // ../../etc/passwd
    EXPECT_EQ(plan_of("filename Yzpcd3JlY2suemlw").name, "wreck.zip");       // c:\wreck.zip
    EXPECT_EQ(plan_of("filename YQ0KYhtb").name, "ab[");                     // a\r\nb\e[
}

TEST(UploadMetadataTest, BecomesADiveByItselfOnlyWhenAskedTo) {
    EXPECT_FALSE(plan_of("filename YQ==").commit);
    EXPECT_TRUE(plan_of("commit").commit);
    const auto plan = plan_of("job cGFwZXI=");
    EXPECT_TRUE(plan.commit);
    EXPECT_EQ(plan.preset, "paper");
}

TEST(UploadMetadataTest, RefusesUnknownPresetsAndBrokenHashes) {
    EXPECT_THROW(plan_of("job bm9uZQ=="), Error);  // none
    EXPECT_THROW(plan_of("job"), Error);
    EXPECT_THROW(plan_of("sha256 YWJj"), Error);  // abc
    EXPECT_THROW(check_sha256(std::string(64, 'A'), "sha256"), Error);
    EXPECT_NO_THROW(check_sha256(std::string(64, 'a'), "sha256"));
}

}  // namespace
}  // namespace divemesh::api
