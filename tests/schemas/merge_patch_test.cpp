#include "schemas/merge_patch.hpp"

#include <gtest/gtest.h>

#include <random>

namespace divemesh {
namespace {

using nlohmann::json;

json random_document(std::mt19937& random, int depth) {
    std::uniform_int_distribution<int> choice(0, depth > 0 ? 5 : 3);
    switch (choice(random)) {
        case 0: return choice(random) % 2;
        case 1: return "text";
        case 2: return json::array({1, nullptr, choice(random)});
        case 3: return 0.5;
        default: break;
    }
    json object = json::object();
    for (const char* key : {"a", "b", "c", "d"})
        if (choice(random) > 1) object[key] = random_document(random, depth - 1);
    return object;
}

// Compares with nlohmann's merge_patch(), another implementation of RFC 7396.
TEST(MergePatchTest, MakesTheOtherDocumentWhateverTheyAre) {
    std::mt19937 random(7);
    for (int i = 0; i < 5000; ++i) {
        json from = {{"x", random_document(random, 3)}};
        const json to = {{"x", random_document(random, 3)}};
        from.merge_patch(merge_patch(from, to));
        ASSERT_EQ(from, to) << i;
    }
}

TEST(MergePatchTest, SaysNothingOfWhatIsTheSame) {
    const json from = {{"a", 1}, {"b", {{"c", 2}, {"d", {1, 2}}}}};
    EXPECT_EQ(merge_patch(from, from), json::object());
    EXPECT_EQ(merge_patch(from, {{"a", 1}, {"b", {{"c", 3}, {"d", {1, 2}}}}}),
              (json{{"b", {{"c", 3}}}}));
}

TEST(MergePatchTest, ANullInAnObjectIsLeftOutAndInAnArrayIsKept) {
    EXPECT_EQ(without_nulls({{"a", nullptr}, {"b", {{"c", nullptr}}}, {"d", {nullptr}}}),
              (json{{"b", json::object()}, {"d", {nullptr}}}));
}

}  // namespace
}  // namespace divemesh
