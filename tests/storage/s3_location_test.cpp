#include "storage/s3_location.hpp"

#include <gtest/gtest.h>

#include "tests/storage/store_fixture.hpp"

namespace divemesh::storage {
namespace {

TEST(S3LocationTest, ReadsBucketPrefixEndpointAndRegion) {
    const auto location =
        parse_s3_url("s3://dives/boat/one?endpoint=http://127.0.0.1:9000&region=eu-west-1");
    EXPECT_EQ(location.bucket, "dives");
    EXPECT_EQ(location.prefix, "boat/one/");
    EXPECT_EQ(location.scheme(), "http");
    EXPECT_EQ(location.host(), "127.0.0.1:9000");
    EXPECT_EQ(location.region, "eu-west-1");
    EXPECT_EQ(location.path("boat/one/x"), "/dives/boat/one/x");
    EXPECT_EQ(location.path(""), "/dives");
    EXPECT_EQ(parse_s3_url("s3://dives?endpoint=http%3A%2F%2F%5B::1%5D:9000").host(), "[::1]:9000");
}

TEST(S3LocationTest, PutsTheBucketIntoTheHostWhereThatIsUsual) {
    const auto amazon = parse_s3_url("s3://dives?region=eu-central-1");
    EXPECT_EQ(amazon.scheme(), "https");
    EXPECT_EQ(amazon.host(), "dives.s3.eu-central-1.amazonaws.com");
    EXPECT_EQ(amazon.path("x"), "/x");
    EXPECT_EQ(amazon.path(""), "/");
    EXPECT_EQ(parse_s3_url("s3://dives?endpoint=https://store.example&style=host").host(),
              "dives.store.example");
    EXPECT_EQ(parse_s3_url("s3://dives?style=path").path("x"), "/dives/x");
}

TEST(S3LocationTest, RefusesWhatItDoesNotUnderstand) {
    for (const std::string url : {"s3://",
                                  "s3://ab",
                                  "s3://Dives",
                                  "s3://dives/../x",
                                  "s3://dives//x",
                                  "s3://dives?endpoint=ftp://host",
                                  "s3://dives?endpoint=127.0.0.1:9000",
                                  "s3://dives?endpoint=http://host/path",
                                  "s3://dives?endpoint=http://host%0d%0aX:y",
                                  "s3://dives?endpoint=http://key:secret@host",
                                  "s3://dives?style=odd",
                                  "s3://dives?region=a/b",
                                  "s3://dives?endpoint=http://host&secret=x"})
        EXPECT_TRUE(throws_code(ErrorCode::InvalidArgument, [&] { parse_s3_url(url); })) << url;
}

TEST(S3LocationTest, ARefusalDoesNotRepeatTheSecret) {
    try {
        parse_s3_url("s3://dives?endpoint=http://key:hidden@host");
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(std::string(error.what()).find("hidden"), std::string::npos) << error.what();
    }
}

}  // namespace
}  // namespace divemesh::storage
