#include <gtest/gtest.h>

#include "schemas/error.hpp"
#include "tests/worker/recording/exif_writer.hpp"
#include "worker/recording/camera_sides.hpp"
#include "worker/recording/civil_time.hpp"
#include "worker/recording/exif_time.hpp"
#include "worker/recording/name_numbers.hpp"
#include "worker/recording/stamp_unit.hpp"
#include "worker/recording/time_table.hpp"

namespace divemesh::recording {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;
// date -u -d "2011-09-26 13:02:25" +%s
constexpr std::int64_t kKitti_s = 1317042145;

const ExifWriter::Texts kDate = {{0x9003, "2011:09:26 13:02:25"}};

TEST(CivilTimeTest, ADateIsTheSecondsThatUnixCounts) {
    EXPECT_EQ(parse_civil_time("2011-09-26 13:02:25.594360375"), kKitti_s * kSecond_ns + 594360375);
    EXPECT_EQ(parse_civil_time("2011:09:26 13:02:25"), kKitti_s * kSecond_ns);
    EXPECT_EQ(parse_civil_time("2011-09-26T13:02:25.5Z"), kKitti_s * kSecond_ns + kSecond_ns / 2);
    EXPECT_EQ(parse_civil_time("1970-01-01 00:00:00"), 0);
    // GNU date: the last second of a leap day.
    EXPECT_EQ(parse_civil_time("2024-02-29 23:59:59"), 1709251199 * kSecond_ns);
}

TEST(CivilTimeTest, WhatIsNoDateIsNone) {
    for (const char* text : {"",
                             "2011-09-26",
                             "2011-13-26 13:02:25",
                             "2011-02-30 13:02:25",
                             "2011-09-26 24:02:25",
                             "2011-09-26 13:02:25.",
                             "2011-09-26 13:02:25.5x",
                             "0000:00:00 00:00:00",
                             "1969-12-31 23:59:59",
                             "2200-01-01 00:00:00",
                             "2011-09-26 13:02:2",
                             "    :  :     :  :  "})
        EXPECT_FALSE(parse_civil_time(text)) << text;
}

TEST(StampUnitTest, NumbersAreExactInEveryUnit) {
    EXPECT_EQ(parse_stamp("1403636580.838555648", StampUnit::Seconds), 1403636580838555648);
    EXPECT_EQ(parse_stamp("1403636580838.5", StampUnit::Milliseconds), 1403636580838500000);
    EXPECT_EQ(parse_stamp("1403636580838555", StampUnit::Microseconds), 1403636580838555000);
    EXPECT_EQ(parse_stamp("1403636580838555648", StampUnit::Nanoseconds), 1403636580838555648);
    EXPECT_EQ(parse_stamp("1.036224e-01", StampUnit::Seconds), 103622400);
    for (const char* text : {"", "-1", "1x", "1.x", "9223372036854775807", "1e300", "nan", "inf"})
        EXPECT_FALSE(parse_stamp(text, StampUnit::Seconds)) << text;
}

TEST(StampUnitTest, TheUnitIsThatInWhichNumbersAreDates) {
    using Numbers = std::vector<std::string>;
    EXPECT_EQ(unit_of_stamps(Numbers{"1403636580838555648"}), StampUnit::Nanoseconds);
    EXPECT_EQ(unit_of_stamps(Numbers{"1403636580838555"}), StampUnit::Microseconds);
    EXPECT_EQ(unit_of_stamps(Numbers{"1403636580838"}), StampUnit::Milliseconds);
    EXPECT_EQ(unit_of_stamps(Numbers{"1403636580"}), StampUnit::Seconds);
    EXPECT_EQ(unit_of_stamps(Numbers{"0.0", "0.1"}), StampUnit::Seconds);
    // Since the machine was started: 20 images a second.
    EXPECT_EQ(unit_of_stamps(Numbers{"5000000000", "5050000000"}), StampUnit::Nanoseconds);
    EXPECT_EQ(unit_of_stamps(Numbers{"5000000000", "5000050000"}), StampUnit::Microseconds);
    EXPECT_EQ(unit_of_stamps(Numbers{"2000000000", "2050000000"}), StampUnit::Nanoseconds);
    EXPECT_EQ(unit_of_stamps(Numbers{"1403636580838.5"}), StampUnit::Milliseconds);
    EXPECT_FALSE(unit_of_stamps(Numbers{"000001", "000002"}));
    EXPECT_FALSE(unit_of_stamps(Numbers{"", "1403636580838555648"}));
    EXPECT_FALSE(unit_of_stamps(Numbers{}));
}

TEST(NameNumbersTest, ATimeIsTheLongestNumberAndACounterTheLast) {
    EXPECT_EQ(longest_number("cam0_1403636580.838555_2"), "1403636580.838555");
    EXPECT_EQ(longest_number("1403636580.838555"), "1403636580.838555");
    EXPECT_EQ(longest_number("a.b"), "");
    EXPECT_EQ(longest_number("1..2."), "1");
    EXPECT_EQ(last_number("GOPR0123"), "0123");
    EXPECT_EQ(last_number("2_x_000017_"), "000017");
    EXPECT_EQ(last_number("x"), "");
}

TEST(TimeTableTest, EverySeparatorHeadingAndUnitGivesTheSameTable) {
    const std::string wanted = "1403636579763555000,a.png\n1403636579813555000,b.png\n";
    for (const char* text :
         {"#t [ns],name\n1403636579763555000,a.png\n1403636579813555000,b.png\n",
          "1403636579.763555 a.png\n1403636579.813555   b.png",
          "\xef\xbb\xbftime;name\r\n1403636579,763555;a.png\r\n1403636579,813555;b.png\r\n",
          "1403636579763555\ta.png\n1403636579813555\tb.png\n",
          ",timestamp,filename\n0,1403636579763555000,a.png\n1,1403636579813555000,b.png\n",
          "\"1403636579763.555\",\"a.png\"\n\"1403636579813.555\",\"b.png\"\n",
          "2014-06-24 19:02:59.763555 a.png\n2014-06-24 19:02:59.813555 b.png\n",
          "2014-06-24T19:02:59.763555Z,a.png\n2014-06-24T19:02:59.813555Z,b.png\n"}) {
        const auto table = convert_time_table(text, std::nullopt);
        ASSERT_TRUE(table) << text;
        EXPECT_EQ(table->csv, wanted) << text;
        EXPECT_TRUE(table->has_fraction);
    }
}

TEST(TimeTableTest, ATableWithoutTimesIsNone) {
    EXPECT_FALSE(convert_time_table("", std::nullopt));
    EXPECT_FALSE(convert_time_table("left,right\na.png,b.png\n", std::nullopt));
    EXPECT_FALSE(convert_time_table("0,a.png\n1,b.png\n", std::nullopt));
    EXPECT_EQ(convert_time_table("0,a.png\n50,b.png\n", StampUnit::Milliseconds)->csv,
              "0,a.png\n50000000,b.png\n");
    EXPECT_FALSE(convert_time_table("-5,a.png\n", StampUnit::Milliseconds));
}

TEST(ExifTimeTest, TheTimeIsReadInBothByteOrdersAndEveryPlace) {
    for (const ByteOrder order : {ByteOrder::Little, ByteOrder::Big}) {
        const std::string tiff = ExifWriter(order).tiff(
            {}, {{0x9003, "2011:09:26 13:02:25"}, {0x9011, "+02:00"}, {0x9291, "59"}});
        const std::int64_t wanted = (kKitti_s - 7200) * kSecond_ns + 590'000'000;
        const std::string jpeg = ExifWriter::in_jpeg("\xff\xd8\xff\xda", tiff);
        std::string png = "\x89PNG\r\n\x1a\n";
        png += std::string("\0\0\0\1abcd!1234\0\0\0", 16);
        png += static_cast<char>(tiff.size()) + std::string("eXIf") + tiff + "1234";
        for (const std::string& image : {tiff, jpeg, png}) {
            const auto time = exif_time(image);
            ASSERT_TRUE(time);
            EXPECT_EQ(time->timestamp_ns, wanted);
            EXPECT_TRUE(time->has_fraction);
        }
    }
}

TEST(ExifTimeTest, WithoutTheOriginalTimeThatOfTheFileIsUsed) {
    const auto time =
        exif_time(ExifWriter(ByteOrder::Big).tiff({{0x0132, "2011:09:26 13:02:25"}}, {}));
    ASSERT_TRUE(time);
    EXPECT_EQ(time->timestamp_ns, kKitti_s * kSecond_ns);
    EXPECT_FALSE(time->has_fraction);
    EXPECT_FALSE(exif_time(ExifWriter(ByteOrder::Big).tiff({}, {{0x9003, "0000:00:00 00:00:00"}})));
}

// A directory that is its own EXIF directory, counts and places beyond the end, every length.
TEST(ExifTimeTest, HostileExifIsReadWithinItsBytesAlone) {
    const ExifWriter writer(ByteOrder::Little);
    const std::string tiff = writer.tiff({}, kDate);
    for (std::size_t size = 0; size < tiff.size(); ++size)
        EXPECT_FALSE(exif_time(tiff.substr(0, size)) && size < tiff.size() - 20) << size;
    std::string circle = tiff;
    circle.replace(8 + 2 + 8, 4, writer.number(8, 4));
    EXPECT_FALSE(exif_time(circle));
    for (const std::uint64_t value : {0xffffffffULL, 0x80000000ULL, 0ULL})
        for (std::size_t at = 4; at + 4 <= tiff.size(); ++at) {
            std::string altered = tiff;
            altered.replace(at, 4, writer.number(value, 4));
            exif_time(altered);
            exif_time(ExifWriter::in_jpeg("\xff\xd8\xff\xda", altered));
        }
    std::string other = tiff;
    other.replace(0, 2, "MM");
    EXPECT_FALSE(exif_time(other));
    EXPECT_FALSE(exif_time(std::string("\xff\xd8\xff\xe1\0\1", 6)));
    EXPECT_FALSE(exif_time(std::string("\xff\xd8\xff\xff\xff\xff", 6)));
}

std::pair<std::size_t, std::size_t> sizes_of(const CameraSides& sides) {
    return {sides.left.size(), sides.right.size()};
}

TEST(CameraSidesTest, EveryWayToNameCamerasIsUnderstood) {
    using Names = std::vector<std::string>;
    dive::FindingLog findings;
    for (const Names& names :
         {Names{"left/0.png", "left/1.png", "right/0.png", "right/1.png"},
          Names{"L_0.png", "L_1.png", "R_0.png", "R_1.png"},
          Names{"0_left.png", "1_left.png", "0_right.png", "1_right.png"},
          Names{"Left0.JPG", "Left1.JPG", "Right0.JPG", "Right1.JPG"},
          Names{"x/cam0/data/0.png", "x/cam0/data/1.png", "x/cam1/data/0.png", "x/cam1/data/1.png"},
          Names{"camera_1/0.png", "camera_1/1.png", "camera_2/0.png", "camera_2/1.png"},
          Names{"image_02/data/0.png",
                "image_02/data/1.png",
                "image_03/data/0.png",
                "image_03/data/1.png"},
          Names{"a/L_0.png", "a/L_1.png", "b/R_0.png", "b/R_1.png"},
          Names{"000_0.png", "001_0.png", "000_1.png", "001_1.png"}})
        EXPECT_EQ(sizes_of(find_camera_sides(names, {}, findings)), std::pair(2UL, 2UL))
            << names.front();
    EXPECT_TRUE(findings.all().empty());
}

TEST(CameraSidesTest, TheWordForTheCameraIsNoPartOfTheName) {
    dive::FindingLog findings;
    const auto sides =
        find_camera_sides({"0017_0.png", "0018_0.png", "0017_1.png", "0018_1.png"}, {}, findings);
    EXPECT_EQ(sides.left.front().stem, "0017_");
    EXPECT_EQ(sides.right.back().stem, "0018_");
    EXPECT_EQ(camera_number("drive/image_02/data/0000000001.png"), 2);
    EXPECT_EQ(camera_number("image_1/000001.png"), 1);
    EXPECT_FALSE(camera_number("left/000001.png"));
}

TEST(CameraSidesTest, OfFourCamerasThoseInColourAreUsedAndTheOthersTold) {
    dive::FindingLog findings;
    const std::vector<std::string> names = {
        "image_0/0.png", "image_1/0.png", "image_2/0.png", "image_3/0.png"};
    EXPECT_EQ(find_camera_sides(names, {}, findings).left.front().name, "image_2/0.png");
    ASSERT_EQ(findings.all().size(), 1U);
    EXPECT_EQ(findings.all().front().code, "images_left_out");
    const auto grey = find_camera_sides(names, {"image_0", "image_1/"}, findings);
    EXPECT_EQ(grey.right.front().name, "image_1/0.png");
}

// TUM-VI has vignettes beside the recording.
TEST(CameraSidesTest, AFewImagesElsewhereAreNoRecording) {
    std::vector<std::string> names = {"dso/cam0/vignette.png", "dso/cam1/vignette.png"};
    for (int i = 10; i < 40; ++i)
        for (const char* camera : {"cam0", "cam1"})
            names.push_back("mav0/" + std::string(camera) + "/data/" + std::to_string(i) + ".png");
    dive::FindingLog findings;
    const auto sides = find_camera_sides(names, {}, findings);
    EXPECT_EQ(sizes_of(sides), std::pair(30UL, 30UL));
    EXPECT_EQ(sides.left.front().name, "mav0/cam0/data/10.png");
}

std::string refusal_of(const std::vector<std::string>& names, const NamedFolders& named = {}) {
    dive::FindingLog findings;
    try {
        find_camera_sides(names, named, findings);
    } catch (const Error& error) {
        return error.what();
    }
    return "";
}

TEST(CameraSidesTest, WhatIsNotClearIsRefusedWithWhatToDo) {
    EXPECT_NE(refusal_of({}).find("no image"), std::string::npos);
    EXPECT_NE(refusal_of({"IMG_0001.JPG", "IMG_0000.JPG"}).find("--left"), std::string::npos);
    EXPECT_NE(refusal_of({"a/left/0.png", "a/right/0.png", "b/left/0.png", "b/right/0.png"})
                  .find("2 folders: a/ b/"),
              std::string::npos);
    EXPECT_NE(refusal_of({"a/l0/0.png", "a/r0/0.png", "b/l0/0.png", "b/r0/0.png"}, {"l0", "r0"})
                  .find("2 folders: a/ b/"),
              std::string::npos);
    EXPECT_NE(refusal_of({"a/0.png", "b/0.png"}, {"a", ""}).find("both"), std::string::npos);
    EXPECT_NE(refusal_of({"a/0.png", "b/0.png"}, {"a", "a"}).find("both"), std::string::npos);
    EXPECT_NE(refusal_of({"a/0.png", "b/0.png"}, {"a", "c"}).find("in c"), std::string::npos);
    // Two images that happen to have the words are not the cameras of a hundred.
    std::vector<std::string> many(100, "x.png");
    many.push_back("left.png");
    many.push_back("right.png");
    EXPECT_NE(refusal_of(many).find("do not tell"), std::string::npos);
}

}  // namespace
}  // namespace divemesh::recording
