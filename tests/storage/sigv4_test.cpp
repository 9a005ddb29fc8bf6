// The examples of Amazon's documentation, "Authenticating Requests: Using the Authorization Header
// (AWS Signature Version 4)", with their published signatures.
#include "storage/sigv4.hpp"

#include <gtest/gtest.h>

#include <gmock/gmock.h>

namespace divemesh::storage {
namespace {

using testing::EndsWith;

const S3Credentials kKeys{"AKIAIOSFODNN7EXAMPLE", "wJalrXUtnFEMI/K7MDENG/bPxRfiCYEXAMPLEKEY", ""};
const std::string kTime = "20130524T000000Z";
const std::string kEmptySha256 = "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855";

std::string signature_of(SignedParts parts, const std::string& sha256 = kEmptySha256) {
    parts.headers["host"] = "examplebucket.s3.amazonaws.com";
    parts.headers["x-amz-content-sha256"] = sha256;
    parts.headers["x-amz-date"] = kTime;
    return sigv4_authorization(parts, kKeys, "us-east-1", kTime, sha256);
}

TEST(Sigv4Test, SignsARangeAsPublished) {
    EXPECT_EQ(signature_of({"GET", "/test.txt", {}, {{"range", "bytes=0-9"}}}),
              "AWS4-HMAC-SHA256 Credential=AKIAIOSFODNN7EXAMPLE/20130524/us-east-1/s3/aws4_request,"
              "SignedHeaders=host;range;x-amz-content-sha256;x-amz-date,"
              "Signature=f0e8bdb87c964420e857bd35b5d6ed310bd44f0170aba48dd91039c6036bdb41");
}

TEST(Sigv4Test, SignsAnObjectWithAnOddNameAsPublished) {
    const std::string sha256 = "44ce7dd67c959e0d3524ffac1771dfbba87d2b6b4b4e99e42034a8b803f8b072";
    EXPECT_THAT(signature_of({"PUT",
                              "/test$file.text",
                              {},
                              {{"date", "Fri, 24 May 2013 00:00:00 GMT"},
                               {"x-amz-storage-class", "REDUCED_REDUNDANCY"}}},
                             sha256),
                EndsWith("=98ad721746da40c64f1a55b78f14c238d841ea1380cd77a1b5971af0ece108bd"));
}

TEST(Sigv4Test, SignsParametersWithoutAValueAsPublished) {
    EXPECT_THAT(signature_of({"GET", "/", {{"lifecycle", ""}}, {}}),
                EndsWith("=fea454ca298b7da1c68078a5d1bdbfbbe0d65c699e0f91ac7a200a0136783543"));
}

TEST(Sigv4Test, SignsAListAsPublished) {
    EXPECT_THAT(signature_of({"GET", "/", {{"prefix", "J"}, {"max-keys", "2"}}, {}}),
                EndsWith("=34b48302e7b5fa45bde8084f4b7868a86f0a534bc59db6670ed5711ef69dc6f7"));
}

TEST(Sigv4Test, EncodesWhatAUrlWouldTakeApart) {
    EXPECT_EQ(percent_encoded("a b/c+d=\xc3\xa4~"), "a%20b%2Fc%2Bd%3D%C3%A4~");
    EXPECT_EQ(percent_encoded("a b/c", true), "a%20b/c");
    EXPECT_EQ(canonical_query({{"b", "1&2"}, {"a", ""}}), "a=&b=1%262");
}

}  // namespace
}  // namespace divemesh::storage
