#include <gtest/gtest.h>

#include <fstream>
#include <functional>

#include "tests/temporary_folder.hpp"
#include "tests/worker/dive/finding_matcher.hpp"
#include "tests/worker/dive/test_archive.hpp"
#include "tests/worker/dive/tiny_dive.hpp"
#include "worker/dive/dive.hpp"
#include "worker/dive/intake.hpp"

namespace divemesh::dive {
namespace {

// A tiny dive in an archive, with an addition.
class BadArchiveTest : public testing::Test {
protected:
    std::vector<Finding> examine(Container container,
                                 const std::function<void(TestArchive&)>& spoil) {
        {
            TestArchive archive(file_, container);
            spoil(archive);
            archive.add_folder(tiny_.folder());
        }
        return examine_file();
    }

    std::vector<Finding> examine_file() {
        return examine_dive(file_, scratch_.path(), base::ignore_progress).findings;
    }

    // Returns the message of the refusal under these limits; "" if the archive opens.
    std::string refusal(const DiveLimits& limits) {
        try {
            Dive::open(file_, scratch_.path(), limits);
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ErrorCode::BadData);
            return error.what();
        }
        return "";
    }

    void write_file(const std::string& bytes) { std::ofstream(file_, std::ios::binary) << bytes; }

    const TemporaryFolder folder_;
    const TemporaryFolder scratch_;
    const TinyDive tiny_{folder_ / "dive"};
    const std::filesystem::path file_ = folder_ / "dive.archive";
};

TEST_F(BadArchiveTest, AnythingElseThanAnArchiveIsRefusedWithItsName) {
    write_file("this is a letter, not a dive\n" + std::string(4000, 'x'));

    EXPECT_THAT(examine_file(), HasFinding(Severity::Error, "not_an_archive", "dive.archive"));
}

TEST_F(BadArchiveTest, AnEmptyFileIsRefused) {
    write_file("");

    EXPECT_THAT(examine_file(), HasFinding(Severity::Error, "not_an_archive", "dive.archive"));
}

TEST_F(BadArchiveTest, AnArchiveWithoutADiveIsRefused) {
    { TestArchive(file_, Container::Zip).add("holiday/beach.jpg", "sand"); }

    EXPECT_THAT(examine_file(), HasFinding(Severity::Error, "not_a_dive", "mav0"));
}

TEST_F(BadArchiveTest, NamesThatLeaveTheFolderAreRefused) {
    for (const std::string name :
         {"../evil.txt", "mav0/../../evil.txt", "/etc/evil.txt", "C:/evil.txt"})
        for (const Container container : {Container::Zip, Container::Tar})
            EXPECT_THAT(examine(container, [&](TestArchive& a) { a.add(name, "boo"); }),
                        HasFinding(Severity::Error, "archive_entry_name", "evil.txt"))
                << name;
}

TEST_F(BadArchiveTest, NamesWithBackslashOrControlCharacterAreRefused) {
    for (const std::string name : {"mav0\\evil.txt", "mav0/\x1b[2Jevil.txt"})
        EXPECT_THAT(examine(Container::Tar, [&](TestArchive& a) { a.add(name, "boo"); }),
                    HasFinding(Severity::Error, "archive_entry_name", "evil.txt"));
}

TEST_F(BadArchiveTest, LinksAndDevicesAreRefused) {
    const auto expect_refused = [&](const std::function<void(TestArchive&)>& spoil) {
        EXPECT_THAT(examine(Container::TarGz, spoil),
                    HasFinding(Severity::Error, "archive_entry_kind", "mav0/odd"));
    };

    expect_refused([](TestArchive& a) { a.add_special("mav0/odd", AE_IFLNK, "/etc/passwd"); });
    expect_refused([](TestArchive& a) { a.add_special("mav0/odd", AE_IFCHR); });
    expect_refused([](TestArchive& a) { a.add_special("mav0/odd", AE_IFIFO); });
    expect_refused([](TestArchive& a) { a.add_hard_link("mav0/odd", "mav0/cam0/data.csv"); });
    EXPECT_THAT(examine(Container::Zip,
                        [](TestArchive& a) { a.add_special("mav0/odd", AE_IFLNK, "/etc/passwd"); }),
                HasFinding(Severity::Error, "archive_entry_kind", "mav0/odd"));
}

TEST_F(BadArchiveTest, TwoEntriesOfOneNameAreRefused) {
    for (const std::string name : {"mav0/cam0/data.csv", "mav0/cam0/DATA.csv"})
        EXPECT_THAT(examine(Container::Tar, [&](TestArchive& a) { a.add(name, "1,a.png\n"); }),
                    HasFinding(Severity::Error, "archive_duplicate", "mav0/cam0/data.csv"));
}

TEST_F(BadArchiveTest, AnEncryptedArchiveIsRefused) {
    { TestArchive(file_, Container::Zip, "secret").add_folder(tiny_.folder()); }

    EXPECT_THAT(examine_file(), HasFinding(Severity::Error, "archive_encrypted", "dive.json"));
}

TEST_F(BadArchiveTest, ABombIsRefusedBeforeItIsUnpacked) {
    const auto bomb = [](TestArchive& a) { a.add("mav0/zeros", std::string(80 << 20, '\0')); };

    EXPECT_THAT(examine(Container::TarGz, bomb),
                HasFinding(Severity::Error, "archive_bomb", "mav0/zeros"));
    EXPECT_THAT(examine(Container::Zip, bomb),
                HasFinding(Severity::Error, "archive_bomb", "mav0/zeros"));
}

TEST_F(BadArchiveTest, LimitsOfCountAndSizeHold) {
    examine(Container::Tar, [](TestArchive& a) { a.add("mav0/big", std::string(5000, 'x')); });
    DiveLimits few;
    few.max_entries = 3;
    DiveLimits small_files;
    small_files.max_file_bytes = 4999;
    DiveLimits small_whole;
    small_whole.max_unpacked_bytes = 5100;

    EXPECT_NE(refusal(few).find("more than 3 entries"), std::string::npos);
    EXPECT_NE(refusal(small_files).find("'mav0/big'"), std::string::npos);
    EXPECT_NE(refusal(small_whole).find("larger than 5100 bytes unpacked"), std::string::npos);
    EXPECT_EQ(refusal({}), "");
}

TEST_F(BadArchiveTest, CompressedTwiceIsRefused) {
    {
        TestArchive inner(folder_ / "inner.tar.gz", Container::TarGz);
        inner.add_folder(tiny_.folder());
    }
    const std::string command =
        "gzip -c '" + (folder_ / "inner.tar.gz").string() + "' > '" + file_.string() + "'";
    ASSERT_EQ(std::system(command.c_str()), 0);

    EXPECT_THAT(examine_file(), HasFinding(Severity::Error, "archive_nested", "dive.archive"));
}

TEST_F(BadArchiveTest, ASizeThatLiesInAZipIsRefused) {
    { TestArchive(file_, Container::Zip).add_folder(tiny_.folder()); }
    std::string bytes;
    {
        std::ifstream stream(file_, std::ios::binary);
        bytes.assign(std::istreambuf_iterator<char>(stream), {});
    }
    // The uncompressed size of the first entry, in every place that states it: local header, data
    // descriptor, central directory (APPNOTE 4.3).
    for (const auto& [signature, offset] :
         {std::pair{"PK\x03\x04", 22}, std::pair{"PK\x07\x08", 12}, std::pair{"PK\x01\x02", 24}})
        if (const std::size_t at = bytes.find(signature); at != std::string::npos)
            bytes[at + static_cast<std::size_t>(offset)] ^= 1;
    write_file(bytes);

    EXPECT_THAT(examine_file(), HasFinding(Severity::Error, "archive_damaged", "dive.json"));
}

}  // namespace
}  // namespace divemesh::dive
