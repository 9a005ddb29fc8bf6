#include "worker/base/atomic_file.hpp"

#include <csignal>
#include <sys/resource.h>

#include "tests/worker/io/test_files.hpp"

namespace divemesh::base {
namespace {

class AtomicFileTest : public io::FileTest {};

// Limits the size of files that this process may write, during its life: imitates a full disk
// without a mount.
class FileSizeLimit {
public:
    explicit FileSizeLimit(rlim_t num_bytes) {
        getrlimit(RLIMIT_FSIZE, &before_);
        handler_before_ = std::signal(SIGXFSZ, SIG_IGN);
        const rlimit limited = {num_bytes, before_.rlim_max};
        setrlimit(RLIMIT_FSIZE, &limited);
    }
    ~FileSizeLimit() {
        setrlimit(RLIMIT_FSIZE, &before_);
        std::signal(SIGXFSZ, handler_before_);
    }
    FileSizeLimit(const FileSizeLimit&) = delete;
    FileSizeLimit& operator=(const FileSizeLimit&) = delete;

private:
    rlimit before_{};
    sighandler_t handler_before_ = SIG_DFL;
};

TEST_F(AtomicFileTest, AppearsUnderItsNameOnlyWhenCommitted) {
    AtomicFile output(file("a.txt"));
    output.write("hello");
    EXPECT_FALSE(std::filesystem::exists(file("a.txt")));
    output.commit();
    EXPECT_EQ(read(file("a.txt")), "hello");
    EXPECT_FALSE(std::filesystem::exists(file("a.txt.partial")));
}

TEST_F(AtomicFileTest, OverwritesWhatItWroteAndContinuesAtTheEnd) {
    const std::string large(3'000'000, 'x');
    AtomicFile output(file("a.txt"));
    output.write("????" + large);
    output.write("end?");
    output.overwrite(0, "head");
    output.overwrite(4 + large.size(), "tail");
    output.write("!");
    output.commit();
    EXPECT_EQ(read(file("a.txt")), "head" + large + "tail!");
}

TEST_F(AtomicFileTest, LeavesTheOldFileAloneWhenItIsGivenUp) {
    write("a.txt", "old");
    { AtomicFile(file("a.txt")).write("new"); }
    EXPECT_EQ(read(file("a.txt")), "old");
    EXPECT_FALSE(std::filesystem::exists(file("a.txt.partial")));
}

TEST_F(AtomicFileTest, AFullDiskIsToldAsSuchAndLeavesTheOldFile) {
    write("a.txt", "old");
    const FileSizeLimit limit(100'000);
    const Error error =
        io::error_of([&] { write_file(file("a.txt"), std::string(3'000'000, 'x')); });
    EXPECT_EQ(error.code(), ErrorCode::OutOfSpace);
    EXPECT_EQ(read(file("a.txt")), "old");
    EXPECT_FALSE(std::filesystem::exists(file("a.txt.partial")));
}

TEST_F(AtomicFileTest, AMissingFolderIsNamed) {
    const Error error = io::error_of([&] { write_file(file("no/such/a.txt"), "x"); });
    EXPECT_EQ(error.code(), ErrorCode::Unavailable);
    EXPECT_NE(std::string(error.what()).find("no/such/a.txt"), std::string::npos);
}

}  // namespace
}  // namespace divemesh::base
