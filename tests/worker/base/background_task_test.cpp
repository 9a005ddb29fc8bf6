#include "worker/base/background_task.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <stdexcept>
#include <thread>
#include <vector>

namespace divemesh::base {
namespace {

class BackgroundTaskOnThreads : public testing::TestWithParam<int> {};

TEST_P(BackgroundTaskOnThreads, RunsWorkInOrder) {
    TaskPool task_pool(GetParam());
    std::vector<int> done;
    {
        BackgroundTask task(task_pool);
        for (int i = 0; i < 100; ++i) task.run([&done, i] { done.push_back(i); });
    }
    ASSERT_EQ(done.size(), 100U);
    for (int i = 0; i < 100; ++i) EXPECT_EQ(done[static_cast<std::size_t>(i)], i);
}

TEST_P(BackgroundTaskOnThreads, AnExceptionIsRethrownByTheNextWaitOnly) {
    TaskPool task_pool(GetParam());
    BackgroundTask task(task_pool);
    task.run([] { throw std::runtime_error("disk full"); });
    EXPECT_THROW(task.wait(), std::runtime_error);
    bool ran = false;
    task.run([&ran] { ran = true; });
    EXPECT_NO_THROW(task.wait());
    EXPECT_TRUE(ran);
}

TEST_P(BackgroundTaskOnThreads, TwoTasksShareTheThreadsWithoutWaitingForEachOther) {
    TaskPool task_pool(GetParam());
    BackgroundTask slow(task_pool);
    BackgroundTask quick(task_pool);
    slow.run([] { std::this_thread::sleep_for(std::chrono::milliseconds(20)); });
    int num_quick = 0;
    for (int i = 0; i < 5; ++i) quick.run([&num_quick] { ++num_quick; });
    quick.wait();
    EXPECT_EQ(num_quick, 5);
    slow.wait();
}

INSTANTIATE_TEST_SUITE_P(Threads, BackgroundTaskOnThreads, testing::Values(1, 2, 4));

}  // namespace
}  // namespace divemesh::base
