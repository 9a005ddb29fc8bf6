#include "api/client/upload_state.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/temporary_folder.hpp"

namespace divemesh::api::client {
namespace {

TEST(UploadStateTest, RemembersWhatWasSavedAndNothingOfOthers) {
    const TemporaryFolder folder;
    const UploadState state(folder.path() / "deep", "http://a", "hash");
    EXPECT_EQ(state.load(), RememberedUpload{});
    const RememberedUpload remembered{"/api/v1/uploads/u", {"/api/v1/uploads/p", ""}, true};
    state.save(remembered);
    EXPECT_EQ(UploadState(folder.path() / "deep", "http://a", "hash").load(), remembered);
    EXPECT_EQ(UploadState(folder.path() / "deep", "http://b", "hash").load(), RememberedUpload{});
    EXPECT_EQ(UploadState(folder.path() / "deep", "http://a", "other").load(), RememberedUpload{});
    state.forget();
    EXPECT_EQ(state.load(), RememberedUpload{});
}

TEST(UploadStateTest, AFileThatCannotBeReadIsNoState) {
    const TemporaryFolder folder;
    const UploadState state(folder.path(), "http://a", "hash");
    state.save({"/api/v1/uploads/u", {}, false});
    const std::filesystem::directory_iterator entry(folder.path());
    ASSERT_TRUE(entry != std::filesystem::directory_iterator()) << "it is kept elsewhere";
    for (const char* text : {"", "{", "[]", "{\"upload\": 3}", "{\"parts\": {}}"}) {
        std::ofstream(entry->path()) << text;
        EXPECT_EQ(state.load(), RememberedUpload{}) << text;
    }
}

}  // namespace
}  // namespace divemesh::api::client
