#include "storage/data_folder.hpp"

#include <gtest/gtest.h>

#include <sys/stat.h>

#include "tests/temporary_folder.hpp"

namespace divemesh::storage {
namespace {

namespace fs = std::filesystem;

fs::perms rights_of_others(const fs::path& folder) {
    return fs::status(folder).permissions() & fs::perms::others_all;
}

TEST(DataFolderTest, IsClosedToOtherUsersWhateverTheUmaskUnlessItIsThere) {
    const TemporaryFolder folder;
    std::error_code failure;
    const mode_t before = umask(0);
    create_data_folder(folder / "data", failure);
    umask(before);
    EXPECT_FALSE(failure);
    EXPECT_EQ(rights_of_others(folder / "data"), fs::perms::none);
    fs::permissions(folder / "data", fs::perms::others_read, fs::perm_options::add);
    create_data_folder(folder / "data", failure);
    EXPECT_FALSE(failure);
    EXPECT_EQ(rights_of_others(folder / "data"), fs::perms::others_read);
}

TEST(DataFolderTest, SaysWhatStandsInItsWay) {
    std::error_code failure;
    create_data_folder("/proc/data", failure);
    EXPECT_TRUE(failure);
}

}  // namespace
}  // namespace divemesh::storage
