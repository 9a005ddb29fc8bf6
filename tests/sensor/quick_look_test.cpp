#include "sensor/quick_look.hpp"

#include <gtest/gtest.h>

#include <ctime>
#include <iostream>
#include <limits>
#include <opencv2/core.hpp>

#include "sensor/recording_source.hpp"
#include "tests/paths.hpp"
#include "tests/sensor/growing_dive.hpp"
#include "tests/temporary_folder.hpp"

namespace divemesh::sensor {
namespace {

// Of a whole dive, two pairs a second.
nlohmann::json look_at(const std::string& dive, double seconds) {
    const auto source = replay_dive(shared_data(dive), 1.0);
    QuickLook look(source->dive_root());
    const auto begin = Clock::now();
    const auto cpu = std::clock();
    for (double time_s = 0.0; time_s <= seconds; time_s += 0.5) {
        source->update(begin + std::chrono::duration_cast<Clock::duration>(
                                   std::chrono::duration<double>(time_s)));
        const auto now = source->newest_frame();
        const auto before = now ? source->newest_frame(now->timestamp_ns) : now;
        if (before) look.look(*before, *now);
    }
    const double cpu_s = static_cast<double>(std::clock() - cpu) / CLOCKS_PER_SEC;
    std::cout << dive << ": " << look.report().dump() << ", " << 100.0 * cpu_s / seconds
              << " % of a core\n";
    return look.report();
}

TEST(QuickLookTest, KnowsHowFarTheTankWasSwum) {
    if (!std::filesystem::exists(shared_data("tank"))) GTEST_SKIP() << "the tank is not there";
    const auto report = look_at("tank", 15.0);
    EXPECT_NEAR(report["distance_m"].get<double>(), 2.99, 0.15);  // of the path: 5 %
    EXPECT_EQ(report["lost"], 0);
    EXPECT_GT(report["coverage"].get<double>(), 0.5);
    EXPECT_GT(report["expected_drift_m"].get<double>(), 0.0);
    EXPECT_LT(report["expected_drift_m"].get<double>(), 0.3);
}

TEST(QuickLookTest, KnowsHowFarTheBargeWasSwum) {
    if (!std::filesystem::exists(shared_data("barge"))) GTEST_SKIP() << "the barge is not there";
    const auto report = look_at("barge", 70.0);
    EXPECT_NEAR(report["distance_m"].get<double>(), 19.76, 1.0);
    EXPECT_LE(report["lost"].get<int>(), 14);
}

TEST(QuickLookTest, CountsFeaturesWithoutACalibration) {
    const TemporaryFolder folder;
    GrowingDive dive(folder.path());
    dive.add_frame();
    DiveTail tail(folder.path());
    tail.update(std::numeric_limits<std::int64_t>::max());
    QuickLook look(tail.root());
    EXPECT_TRUE(look.report().is_null());
    look.look(*tail.newest_frame(), *tail.newest_frame());
    EXPECT_GT(look.report()["features"].get<int>(), 5);
    EXPECT_FALSE(look.report().contains("distance_m"));
}

}  // namespace
}  // namespace divemesh::sensor
