#include "worker/reef/shapefile_outlines.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "schemas/error.hpp"
#include "tests/worker/reef/shapefile_bytes.hpp"

namespace divemesh::reef {
namespace {

Polygon reversed(Polygon ring) {
    std::reverse(ring.begin(), ring.end());
    return ring;
}

std::string refusal(const std::string& bytes, const DbfTable& table = {}) {
    try {
        shapefile_outlines(bytes, table);
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::BadData);
        return error.what();
    }
    return "";
}

// Returns a table of the columns `name` (10 bytes) and `class` (8 bytes).
std::string dbf(const std::vector<std::pair<std::string, std::string>>& rows) {
    const std::size_t header = 32 + 2 * 32 + 1;
    std::string bytes("\x03\x7e\x01\x01", 4);
    bytes += static_cast<char>(rows.size());
    bytes.append(3, '\0');
    bytes += {static_cast<char>(header), '\0', 19, '\0'};
    bytes.append(20, '\0');
    for (const auto& [name, length] : {std::pair{"name", 10}, {"class", 8}}) {
        std::string field = name;
        field.resize(11, '\0');
        field += 'C';
        field.resize(32, '\0');
        field[16] = static_cast<char>(length);
        bytes += field;
    }
    bytes += '\r';
    for (const auto& [name, label] : rows) {
        std::string row = " " + name;
        row.resize(11, ' ');
        row += label;
        row.resize(19, ' ');
        bytes += row;
    }
    return bytes + '\x1a';
}

TEST(ShapefileOutlines, PolygonsAndLinesOfEveryKindAreRead) {
    for (const std::uint32_t type : {3U, 13U, 23U, 5U, 15U, 25U}) {
        ShapefileBytes file(type);
        file.add({clockwise_square(1, 2, 3)});
        const OutlineFile read = shapefile_outlines(file.bytes(), {});
        ASSERT_EQ(read.outlines.size(), 1U) << type;
        EXPECT_EQ(read.outlines[0].is_line, type % 10 == 3) << type;
        EXPECT_EQ(read.outlines[0].points, clockwise_square(1, 2, 3)) << type;
    }
}

TEST(ShapefileOutlines, ARingIsAHoleOnlyIfItRunsTheOtherWayWithinAnother) {
    ShapefileBytes file(5);
    file.add({clockwise_square(0, 0, 10),
              reversed(clockwise_square(1, 1, 2)),
              clockwise_square(20, 0, 5),
              reversed(clockwise_square(40, 0, 1))});
    file.add({reversed(clockwise_square(0, 0, 1))});
    const OutlineFile read = shapefile_outlines(file.bytes(), {});
    ASSERT_EQ(read.outlines.size(), 4U);
    EXPECT_EQ(read.outlines[0].num_holes, 1);
    EXPECT_EQ(read.outlines[1].num_holes, 0);
    EXPECT_EQ(read.outlines[2].feature, 0U);
    EXPECT_EQ(read.outlines[3].feature, 1U);
    EXPECT_EQ(read.outlines[3].num_holes, 0);
}

TEST(ShapefileOutlines, RowsOfTheTableBelongToTheShapesInTheirOrder) {
    ShapefileBytes file(5);
    file.add_null();
    file.add({clockwise_square(0, 0, 1)});
    const std::string latin1 = "Ac\xe9ro";
    const DbfTable table = read_dbf(dbf({{"q1", ""}, {latin1, "Porites"}}));
    const OutlineFile read = shapefile_outlines(file.bytes(), table);
    ASSERT_EQ(read.outlines.size(), 1U);
    EXPECT_EQ(read.outlines[0].columns.at("name"), "Ac\xc3\xa9ro");
    EXPECT_EQ(read.outlines[0].columns.at("class"), "Porites");
    EXPECT_NE(refusal(file.bytes(), DbfTable(3)).find("2 shapes"), std::string::npos);
}

TEST(ShapefileOutlines, WhatAnnouncesMoreThanItHoldsIsRefusedBeforeItTakesMemory) {
    ShapefileBytes file(5);
    file.add({clockwise_square(0, 0, 1)});
    ShapefileBytes claims = file;
    claims.claim_points(0x80000000U);
    EXPECT_NE(refusal(claims.bytes()).find("record 1: it announces 2147483648 points"),
              std::string::npos);
    for (std::size_t size = 101; size < file.bytes().size(); ++size)
        EXPECT_FALSE(refusal(file.bytes().substr(0, size)).empty()) << size;
    const std::string table = dbf({{"a", "b"}});
    for (std::size_t size = 0; size + 1 < table.size(); ++size)
        EXPECT_THROW(read_dbf(table.substr(0, size)), Error) << size;
    std::string many = table;
    many[7] = '\x7f';
    EXPECT_THROW(read_dbf(many), Error);
}

TEST(ShapefileOutlines, ShapesWithoutAnOutlineAreRefusedByName) {
    ShapefileBytes patch(31);
    patch.add({clockwise_square(0, 0, 1)});
    EXPECT_NE(refusal(patch.bytes()).find("shapes of type 31"), std::string::npos);
}

}  // namespace
}  // namespace divemesh::reef
