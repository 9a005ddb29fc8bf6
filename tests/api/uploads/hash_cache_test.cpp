#include "api/uploads/hash_cache.hpp"

#include <gtest/gtest.h>

namespace divemesh::api {
namespace {

TEST(HashCacheTest, GoesOnOnlyFromExactlyTheBytesItHasSeen) {
    HashCache cache;
    auto hash = cache.take("upload_a", 0);
    ASSERT_TRUE(hash);
    hash->update(std::string_view("div"));
    cache.put("upload_a", 3, std::move(*hash));
    EXPECT_FALSE(cache.take("upload_a", 2));
    EXPECT_FALSE(cache.take("upload_b", 3));
    auto rest = cache.take("upload_a", 3);
    ASSERT_TRUE(rest);
    rest->update(std::string_view("emesh"));
    EXPECT_EQ(rest->hex(), sha256_hex("divemesh"));
    EXPECT_FALSE(cache.take("upload_a", 3));
}

TEST(HashCacheTest, ForgetsTheOldestWhenThereAreTooMany) {
    HashCache cache;
    for (int i = 0; i < 5000; ++i) cache.put("upload_" + std::to_string(i), 1, Sha256());
    EXPECT_FALSE(cache.take("upload_0", 1));
    EXPECT_TRUE(cache.take("upload_4999", 1));
}

}  // namespace
}  // namespace divemesh::api
