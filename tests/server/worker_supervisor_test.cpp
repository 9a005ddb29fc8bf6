#include "server/worker_supervisor.hpp"

#include <gtest/gtest.h>

#include <csignal>
#include <fcntl.h>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <unistd.h>

#include "schemas/file_descriptor.hpp"
#include "tests/temporary_folder.hpp"

namespace divemesh::server {
namespace {

using namespace std::chrono_literals;

std::string read_text(const std::filesystem::path& file) {
    std::ifstream stream(file);
    return {std::istreambuf_iterator<char>(stream), {}};
}

std::set<pid_t> pids_in(const std::filesystem::path& file) {
    std::ifstream stream(file);
    std::set<pid_t> pids;
    for (pid_t pid = 0; stream >> pid;) pids.insert(pid);
    return pids;
}

bool has_pids(const std::filesystem::path& file, std::size_t count) {
    for (int i = 0; i < 1000 && pids_in(file).size() < count; ++i)
        std::this_thread::sleep_for(20ms);
    return pids_in(file).size() >= count;
}

std::vector<std::string> write_pid_and_wait(const std::filesystem::path& file) {
    return {"/bin/sh", "-c", "echo $$ >> " + file.string() + "; exec sleep 600"};
}

TEST(WorkerSupervisorTest, StartsAKilledWorkerAgainAndEndsAllWithItself) {
    const TemporaryFolder folder;
    const auto file = folder / "pids";
    {
        const WorkerSupervisor workers(write_pid_and_wait(file), 2);
        ASSERT_TRUE(has_pids(file, 2));
        kill(*pids_in(file).begin(), SIGKILL);
        EXPECT_TRUE(has_pids(file, 3));
    }
    for (const pid_t pid : pids_in(file)) EXPECT_NE(kill(pid, 0), 0);
}

TEST(WorkerSupervisorTest, PausesBeforeItStartsAWorkerThatCannotRun) {
    const TemporaryFolder folder;
    const auto file = folder / "pids";
    {
        const WorkerSupervisor workers(
            {"/bin/sh", "-c", "echo $$ >> " + file.string() + "; exit 1"}, 1);
        ASSERT_TRUE(has_pids(file, 2));
        std::this_thread::sleep_for(500ms);  // the second pause is two seconds
    }
    EXPECT_LE(pids_in(file).size(), 3U);
}

// A worker that outlives a killed server would hold the server's port.
TEST(WorkerSupervisorTest, WorkersInheritNoneOfTheServersDescriptors) {
    const TemporaryFolder folder;
    const auto file = folder / "descriptors";
    const FileDescriptor descriptor(open((folder / "socket").c_str(), O_RDWR | O_CREAT, 0600));
    ASSERT_TRUE(descriptor.is_open());
    {
        const WorkerSupervisor workers(
            {"/bin/sh",
             "-c",
             "ls -l /proc/$$/fd > " + file.string() + ".part; mv " + file.string() + ".part " +
                 file.string() + "; exec sleep 600"},
            1);
        for (int i = 0; i < 1000 && !std::filesystem::exists(file); ++i)
            std::this_thread::sleep_for(20ms);
    }
    const std::string listed = read_text(file);
    EXPECT_NE(listed.find("0 -> "), std::string::npos) << listed;
    EXPECT_EQ(listed.find((folder / "socket").string()), std::string::npos) << listed;
}

}  // namespace
}  // namespace divemesh::server
