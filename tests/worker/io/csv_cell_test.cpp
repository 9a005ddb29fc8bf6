#include "worker/io/csv_cell.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace divemesh::io {
namespace {

TEST(CsvCellTest, ATextWithCommaOrQuotesIsQuoted) {
    EXPECT_EQ(csv_cell("plain"), "plain");
    EXPECT_EQ(csv_cell("a,b"), "\"a,b\"");
    EXPECT_EQ(csv_cell("a \"b\""), "\"a \"\"b\"\"\"");
}

TEST(CsvCellTest, ATextThatASpreadsheetWouldRunIsPrefixed) { EXPECT_EQ(csv_cell("=1+1"), "'=1+1"); }

TEST(CsvCellTest, AJsonValueIsACellByItsType) {
    EXPECT_EQ(csv_cell_of(nullptr), "");
    EXPECT_EQ(csv_cell_of("=a,b"), "\"'=a,b\"");
    EXPECT_EQ(csv_cell_of(-1.5), "-1.5");
    EXPECT_EQ(csv_cell_of(true), "true");
}

}  // namespace
}  // namespace divemesh::io
