#include "schemas/content_hash.hpp"

#include <gtest/gtest.h>

#include "schemas/desktop_files.hpp"
#include "schemas/error.hpp"

namespace divemesh {
namespace {

// FIPS 180-2, appendix B.1 and B.2.
TEST(Sha256Test, GivesThePublishedDigests) {
    EXPECT_EQ(sha256_hex("abc"),
              "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
    EXPECT_EQ(sha256_hex("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
              "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
}

TEST(Sha256Test, GoesOnAfterItWasAskedForItsDigest) {
    Sha256 hash;
    hash.update(std::string_view("a"));
    EXPECT_EQ(hash.hex(), sha256_hex("a"));
    hash.update(std::string_view("bc"));
    EXPECT_EQ(hash.hex(), sha256_hex("abc"));
}

// The digest is what `sha256sum mav0/a mav0/b
// sha256sum` prints for files with "abc" and "".
TEST(ContentHashTest, IsTheDigestOfTheSortedListThatSha256sumPrints) {
    const std::vector<HashedFile> files = {{"mav0/b", sha256_hex("")},
                                           {"mav0/a", sha256_hex("abc")}};
    EXPECT_EQ(content_sha256(files),
              "3b476631f136677ffcddc6687d9b181706da0106060e7329a4d263ccd90b5ae2");
}

TEST(ContentHashTest, KnowsWhatDesktopsLeave) {
    for (const char* path : {".DS_Store", "a/.DS_Store", "a/._b.png", "Thumbs.db", "a/desktop.ini"})
        EXPECT_TRUE(is_left_by_desktop(path)) << path;
    for (const char* path : {"DS_Store", "a/b._c", ".hidden", "thumbs.db/a", "Thumbs.db.csv"})
        EXPECT_FALSE(is_left_by_desktop(path)) << path;
    EXPECT_EQ(content_sha256({{"a", sha256_hex("x")}, {".DS_Store", sha256_hex("y")}}),
              content_sha256({{"a", sha256_hex("x")}}));
}

// The digests are what `sha256sum mav0/a | sha256sum` and `sha256sum .DS_Store mav0/a | sha256sum`
// print for files with "seen" and "abc".
TEST(ContentHashTest, MatchesWhatEarlierVersionsStated) {
    constexpr auto kToday = "2bdb05d3968c2c2844cf36dfaadc22cbd6d1d31165dd7fc86e937ffee61dd58f";
    constexpr auto kEarlier = "10a6d48fa887e10bf52b76bb556a70010548b7d4300d106fd097082f6789494b";
    const HashedFile image{"mav0/a", sha256_hex("abc")};
    const HashedFile desktop{".DS_Store", sha256_hex("seen")};

    EXPECT_TRUE(content_hash({image, desktop}).matches(kToday));
    EXPECT_TRUE(content_hash({image, desktop}).matches(kEarlier));
    EXPECT_TRUE(content_hash({image}).matches(kToday));
    EXPECT_FALSE(content_hash({image}).matches(kEarlier));
    EXPECT_FALSE(content_hash({image}).matches(""));
    EXPECT_FALSE(content_hash({image, desktop}).matches(sha256_hex("something else")));
}

TEST(ContentHashTest, RefusesTwoFilesOfOneNameAndLineEndsInNames) {
    EXPECT_THROW(content_sha256({{"a", sha256_hex("")}, {"a", sha256_hex("x")}}), Error);
    EXPECT_THROW(content_sha256({{"a\nb", sha256_hex("")}}), Error);
}

TEST(DiveRootTest, NamesAFileAlikeWhereverTheDiveLies) {
    const auto name_in = [](const std::string& path) {
        return path_in_dive(find_dive_root({path}).value(), path);
    };
    EXPECT_EQ(name_in("mav0/cam0/data.csv"), "mav0/cam0/data.csv");
    EXPECT_EQ(name_in("MH_01_easy/mav0/cam0/data.csv"), "mav0/cam0/data.csv");
    EXPECT_EQ(name_in("cam0/data.csv"), "mav0/cam0/data.csv");
    EXPECT_EQ(name_in("sub/cam0/data.csv"), "mav0/cam0/data.csv");
}

TEST(DiveRootTest, LeavesOutWhatLiesBesideTheDive) {
    const auto root =
        find_dive_root({"__MACOSX/dive/mav0/._cam0", "dive/dive.json", "dive/mav0/cam0/data.csv"});
    ASSERT_TRUE(root);
    EXPECT_EQ(path_in_dive(*root, "dive/dive.json"), "dive.json");
    EXPECT_FALSE(path_in_dive(*root, "__MACOSX/dive/mav0/._cam0"));
}

TEST(DiveRootTest, KnowsNoRootWithoutCameras) {
    EXPECT_FALSE(find_dive_root({"readme.txt", "cam0", "notmav0/x"}));
}

}  // namespace
}  // namespace divemesh
