#include "api/field_values.hpp"

#include <gtest/gtest.h>

namespace divemesh::api {
namespace {

TEST(FieldValuesTest, ElementsOfAListAreInLowerCaseAndNeverEmpty) {
    EXPECT_EQ(list_elements("gzip, Chunked"), (std::vector<std::string>{"gzip", "chunked"}));
    EXPECT_EQ(list_elements(" ,\tGZIP\t,,"), std::vector<std::string>{"gzip"});
    EXPECT_TRUE(list_elements("").empty());
    EXPECT_TRUE(list_elements(" , ").empty());
}

TEST(FieldValuesTest, AMediaTypeHasNeitherCaseNorParameters) {
    EXPECT_EQ(media_type_of("Application/JSON"), "application/json");
    EXPECT_EQ(media_type_of("application/merge-patch+json ; charset=utf-8"),
              "application/merge-patch+json");
    EXPECT_EQ(media_type_of("text/plain; note=\"application/json\""), "text/plain");
    EXPECT_EQ(media_type_of(""), "");
}

}  // namespace
}  // namespace divemesh::api
