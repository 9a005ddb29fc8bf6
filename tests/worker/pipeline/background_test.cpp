#include "worker/background.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <stdexcept>
#include <thread>
#include <vector>

namespace divemesh::worker {
namespace {

class BackgroundOnThreads : public testing::TestWithParam<int> {};

TEST_P(BackgroundOnThreads, DoesOnePieceAfterTheOther) {
    Workers workers(GetParam());
    std::vector<int> done;
    {
        Background background(workers);
        for (int i = 0; i < 100; ++i) background.run([&done, i] { done.push_back(i); });
    }
    ASSERT_EQ(done.size(), 100U);
    for (int i = 0; i < 100; ++i) EXPECT_EQ(done[static_cast<std::size_t>(i)], i);
}

TEST_P(BackgroundOnThreads, WhatIsThrownComesOutAtTheNextWaitAndOnlyThere) {
    Workers workers(GetParam());
    Background background(workers);
    background.run([] { throw std::runtime_error("disk full"); });
    EXPECT_THROW(background.wait(), std::runtime_error);
    bool ran = false;
    background.run([&ran] { ran = true; });
    EXPECT_NO_THROW(background.wait());
    EXPECT_TRUE(ran);
}

TEST_P(BackgroundOnThreads, TwoOfThemShareTheWorkersWithoutWaitingForEachOther) {
    Workers workers(GetParam());
    Background slow(workers);
    Background quick(workers);
    slow.run([] { std::this_thread::sleep_for(std::chrono::milliseconds(20)); });
    int num_quick = 0;
    for (int i = 0; i < 5; ++i) quick.run([&num_quick] { ++num_quick; });
    quick.wait();
    EXPECT_EQ(num_quick, 5);
    slow.wait();
}

INSTANTIATE_TEST_SUITE_P(Threads, BackgroundOnThreads, testing::Values(1, 2, 4));

}  // namespace
}  // namespace divemesh::worker
