#include "worker/dive/pack_file.hpp"

#include <gtest/gtest.h>

#include <csignal>
#include <string>
#include <sys/resource.h>

#include "schemas/error.hpp"
#include "tests/temporary_folder.hpp"

namespace divemesh::dive {
namespace {

TEST(PackFileTest, GivesBackWhatWasAppended) {
    const TemporaryFolder folder;
    PackFile pack(folder.path());
    pack.append(std::string_view("first"));
    pack.append(std::string_view("second"));
    std::string part(6, ' ');

    pack.read(5, part);

    EXPECT_EQ(part, "second");
    EXPECT_EQ(pack.size_bytes(), 11);
}

// The size limit of the process imitates a full disk: mounting one needs rights that a test lacks.
TEST(PackFileTest, AFullDiskIsSaidAsOutOfSpace) {
    const TemporaryFolder folder;
    PackFile pack(folder.path());
    rlimit before{};
    ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
    const auto previous = std::signal(SIGXFSZ, SIG_IGN);
    const rlimit small{1 << 20, before.rlim_max};
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
    ErrorCode code = ErrorCode::Conflict;

    try {
        pack.append(std::string(2 << 20, 'x'));
    } catch (const Error& error) {
        code = error.code();
    }
    setrlimit(RLIMIT_FSIZE, &before);
    std::signal(SIGXFSZ, previous);

    EXPECT_EQ(code, ErrorCode::OutOfSpace);
}

}  // namespace
}  // namespace divemesh::dive
