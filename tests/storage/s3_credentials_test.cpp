#include "storage/s3_credentials.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/storage/store_fixture.hpp"
#include "tests/temporary_folder.hpp"

namespace divemesh::storage {
namespace {

class S3CredentialsTest : public testing::Test {
protected:
    std::filesystem::path file(const std::string& text) const {
        std::ofstream(folder_ / "credentials") << text;
        return folder_ / "credentials";
    }

    TemporaryFolder folder_;
};

TEST_F(S3CredentialsTest, AreReadFromTheProfileThatIsAskedFor) {
    const auto path = file(
        "# keys\n[default]\naws_access_key_id = one\naws_secret_access_key=a/b+c==\n"
        "[boat]\r\naws_access_key_id=two\r\naws_secret_access_key=d\r\naws_session_token=e\r\n");

    const auto usual = read_s3_credentials(path, "default");
    EXPECT_EQ(usual.access_key, "one");
    EXPECT_EQ(usual.secret_key, "a/b+c==");
    EXPECT_EQ(usual.session_token, "");
    const auto boat = read_s3_credentials(path, "boat");
    EXPECT_EQ(boat.access_key, "two");
    EXPECT_EQ(boat.secret_key, "d");
    EXPECT_EQ(boat.session_token, "e");
}

TEST_F(S3CredentialsTest, AreRefusedIfTheyAreNotThere) {
    const auto refused = [](const std::filesystem::path& path, const std::string& profile) {
        return throws_code(ErrorCode::InvalidArgument, [&] { read_s3_credentials(path, profile); });
    };
    EXPECT_TRUE(refused(folder_ / "none", "default"));
    EXPECT_TRUE(refused(file("[default]\naws_access_key_id=one\n"), "default"));
    EXPECT_TRUE(
        refused(file("[other]\naws_access_key_id=a\naws_secret_access_key=b\n"), "default"));
    EXPECT_TRUE(refused(file(std::string(100'000, 'x')), "default"));
}

TEST_F(S3CredentialsTest, OfTheEnvironmentComeFirst) {
    setenv("AWS_SHARED_CREDENTIALS_FILE",
           file("[boat]\naws_access_key_id=a\naws_secret_access_key=b\n").c_str(),
           1);
    setenv("AWS_PROFILE", "boat", 1);
    unsetenv("AWS_ACCESS_KEY_ID");
    unsetenv("AWS_SECRET_ACCESS_KEY");
    EXPECT_EQ(find_s3_credentials().access_key, "a");
    setenv("AWS_ACCESS_KEY_ID", "c", 1);
    setenv("AWS_SECRET_ACCESS_KEY", "d", 1);
    setenv("AWS_SESSION_TOKEN", "e", 1);
    EXPECT_EQ(find_s3_credentials().access_key, "c");
    EXPECT_EQ(find_s3_credentials().session_token, "e");
}

}  // namespace
}  // namespace divemesh::storage
