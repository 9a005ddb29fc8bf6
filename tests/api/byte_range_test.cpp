#include "api/byte_range.hpp"

#include <gtest/gtest.h>

namespace divemesh::api {
namespace {

struct Case {
    const char* header;
    std::int64_t size;
    std::int64_t offset;  // -1: outside the file
    std::int64_t length;
    bool partial;
};

TEST(ByteRangeTest, AnswersSingleRangesAsRfc9110Says) {
    // clang-format off
    const Case cases[] = {
        {"",               100,  0, 100, false},
        {"bytes=0-9",      100,  0,  10, true},
        {"bytes=90-",      100, 90,  10, true},
        {"bytes=90-1000",  100, 90,  10, true},
        {"bytes=-5",       100, 95,   5, true},
        {"bytes=-500",     100,  0, 100, true},
        {"bytes=99-99",    100, 99,   1, true},
        {"bytes=100-",     100, -1,   0, true},
        {"bytes=-0",       100, -1,   0, true},
        {"bytes=0-",         0, -1,   0, true},
        {"bytes=5-2",      100,  0, 100, false},
        {"bytes=a-b",      100,  0, 100, false},
        {"bytes=-",        100,  0, 100, false},
        {"bytes=0-1,5-6",  100,  0, 100, false},
        {"lines=0-1",      100,  0, 100, false},
        {"Bytes=0-9",      100,  0,  10, true},
        {"bytes=0-99999999999999999999", 100, 0, 100, true},
        {"bytes=99999999999999999999-",  100, -1, 0, true},
        {"bytes=-99999999999999999999",  100, 0, 100, true},
        {"bytes=9x-",      100,  0, 100, false},
        {"bytes=-1-",      100,  0, 100, false},
        {"bytes 0-9",      100,  0, 100, false},
    };
    // clang-format on
    for (const Case& c : cases) {
        const auto answer = parse_range(c.header, c.size);
        EXPECT_EQ(answer.partial, c.partial) << c.header;
        ASSERT_EQ(answer.range.has_value(), c.offset >= 0) << c.header;
        if (!answer.range) continue;
        EXPECT_EQ(answer.range->offset, c.offset) << c.header;
        EXPECT_EQ(answer.range->length, c.length) << c.header;
    }
}

// The digest of an empty text, as in the examples of RFC 9530.
TEST(ByteRangeTest, WritesADigestAsAStructuredField) {
    EXPECT_EQ(digest_field("e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855"),
              "sha-256=:47DEQpj8HBSa+/TImW+5JCeuQeRkm5NMpJWZG3hSuFU=:");
}

TEST(ByteRangeTest, LeavesNothingInAFileNameThatAHeaderCouldMisread) {
    EXPECT_EQ(content_disposition("inline", "keyframes/1.jpg"),
              "inline; filename=\"1.jpg\"; filename*=UTF-8''1.jpg");
    const auto hostile = content_disposition("attachment", "a\"\r\nSet-Cookie: x");
    EXPECT_EQ(hostile.find('\r'), std::string::npos);
    EXPECT_EQ(hostile,
              "attachment; filename=\"a___Set-Cookie__x\"; "
              "filename*=UTF-8''a%22%0D%0ASet-Cookie%3A%20x");
}

}  // namespace
}  // namespace divemesh::api
