#include "worker/base/scratch_file.hpp"

#include <gtest/gtest.h>

#include "schemas/error.hpp"
#include "tests/temporary_folder.hpp"

namespace divemesh::base {
namespace {

TEST(ScratchFileTest, GivesBackWhatWasAppended) {
    const TemporaryFolder folder;
    ScratchFile file(folder.path());
    file.append("first");
    file.append("");
    file.append("second");

    EXPECT_EQ(file.read(5, 6), "second");
    EXPECT_EQ(file.read(0, 11), "firstsecond");
    EXPECT_EQ(file.read(3, 0), "");
    EXPECT_TRUE(std::filesystem::is_empty(folder.path()));  // it has no name
}

TEST(ScratchFileTest, AFolderThatIsMissingIsNamed) {
    try {
        ScratchFile file("/nowhere/at/all");
        FAIL() << "made a file in a folder that is not there";
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ErrorCode::OutOfSpace);
        EXPECT_NE(std::string(error.what()).find("/nowhere/at/all"), std::string::npos);
    }
}

}  // namespace
}  // namespace divemesh::base
