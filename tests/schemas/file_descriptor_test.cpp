#include "schemas/file_descriptor.hpp"

#include <gtest/gtest.h>

#include <fcntl.h>

namespace divemesh {
namespace {

bool is_open(int number) { return ::fcntl(number, F_GETFD) >= 0; }

FileDescriptor null_device() { return FileDescriptor(::open("/dev/null", O_RDONLY | O_CLOEXEC)); }

TEST(FileDescriptorTest, ClosesWhatItHoldsAndKeepsTheErrorThatIsBeingReported) {
    int number = -1;
    {
        const FileDescriptor file = null_device();
        number = file.get();
        ASSERT_TRUE(is_open(number));
        errno = ENOSPC;
    }
    EXPECT_EQ(errno, ENOSPC);
    EXPECT_FALSE(is_open(number));
}

TEST(FileDescriptorTest, IsHandedOnByMoving) {
    FileDescriptor from = null_device();
    const int number = from.get();
    const FileDescriptor to = std::move(from);
    EXPECT_EQ(to.get(), number);
    EXPECT_TRUE(is_open(number));
}

TEST(FileDescriptorTest, ReleasedItStaysOpen) {
    int number = -1;
    {
        FileDescriptor file = null_device();
        number = file.release();
        EXPECT_FALSE(file.is_open());
    }
    EXPECT_TRUE(is_open(number));
    EXPECT_TRUE(FileDescriptor(number).close());
}

TEST(FileDescriptorTest, ClosingTellsWhetherTheSystemCould) {
    FileDescriptor file = null_device();
    EXPECT_TRUE(file.close());
    EXPECT_FALSE(file.is_open());
    EXPECT_TRUE(file.close());
    FileDescriptor gone(1 << 20);  // a descriptor number that is not in use
    EXPECT_FALSE(gone.close());
    EXPECT_EQ(errno, EBADF);
}

}  // namespace
}  // namespace divemesh
