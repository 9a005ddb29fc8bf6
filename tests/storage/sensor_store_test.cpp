#include "storage/sensor_store.hpp"

#include <algorithm>
#include <gmock/gmock.h>
#include <numeric>
#include <random>

#include "schemas/json.hpp"
#include "storage/sensor_history.hpp"
#include "tests/storage/store_fixture.hpp"

namespace divemesh::storage {
namespace {

using nlohmann::json;
using testing::ElementsAre;
using testing::IsEmpty;

SensorMessage status(std::int64_t sequence, std::int64_t uptime_ms, json body = json::object()) {
    return {.sequence = sequence, .uptime_ms = uptime_ms, .body = std::move(body)};
}
SensorMessage historical(SensorMessage message) {
    message.historical = true;
    return message;
}

class SensorStoreTest : public StoreTest {
protected:
    SensorAnswer send(const std::string& boot,
                      std::vector<SensorMessage> messages,
                      const std::string& sensor = "aqua") {
        const auto outcomes =
            sensors_.receive({{sensor, "default", {boot, std::move(messages), {}}}});
        EXPECT_FALSE(outcomes.at(0).failure);
        return outcomes.at(0).answer;
    }
    // As if so much time had passed since all that was heard.
    void pass(std::int64_t ms) {
        catalog_.transaction([&](soci::session& session) {
            session << "UPDATE sensors SET seen_at_ms = seen_at_ms - " << ms
                    << ", status_at_ms = status_at_ms - " << ms
                    << ", back_at_ms = CASE back_at_ms WHEN 0 THEN 0 ELSE back_at_ms - " << ms
                    << " END, twin_at_ms = twin_at_ms - " << ms;
        });
        sensors_.look_at_the_time();
    }
    std::vector<std::string> told() {
        std::vector<std::string> lines;
        for (const Event& event : events_.since(0, "", 1000)) {
            if (event.topic != "sensor") continue;
            EXPECT_EQ(event.data.at("sensor"), event.subject);
            if (event.type == "sensor.state")
                lines.push_back(event.data.at("state"));
            else
                lines.push_back(event.data.at("name").get<std::string>() + " " +
                                (event.data.at("raised").get<bool>() ? "raised" : "over"));
        }
        return lines;
    }
    std::int64_t now_ms() {
        std::int64_t now = 0;
        catalog_.read([&](soci::session& session) { now = Catalog::now_ms(session); });
        return now;
    }
    // Returns the times of the history, in steps of a millisecond.
    std::vector<std::int64_t> times(std::int64_t from_ms, std::int64_t to_ms) {
        HistoryRequest request{"aqua", from_ms, to_ms, static_cast<int>(to_ms - from_ms), {}};
        std::vector<std::int64_t> times;
        for (const auto& step : read_history(catalog_, request).steps)
            for (std::int64_t i = 0; i < step.num_statuses; ++i) times.push_back(step.time_ms);
        return times;
    }

    SensorStore sensors_{catalog_};
};

TEST_F(SensorStoreTest, ShowsTheNewestStatusOfNowAndHowOldItIs) {
    SensorMessage hello = status(0, 100, {{"firmware", "2.1"}});
    hello.kind = MessageKind::Hello;
    const SensorAnswer answer =
        send("a", {hello, status(1, 200, {{"battery", 0.8}, {"vendor", "kept"}})});
    EXPECT_EQ(answer.acknowledged, 1);
    EXPECT_EQ(answer.num_new, 2);
    EXPECT_FALSE(answer.superseded);

    const Sensor sensor = sensors_.get("aqua");
    EXPECT_EQ(sensor.state, SensorState::Online);
    EXPECT_EQ(sensor.boot_id, "a");
    EXPECT_EQ(sensor.hello.at("firmware"), "2.1");
    EXPECT_EQ(sensor.status.at("vendor"), "kept");
    EXPECT_FALSE(sensor.stale);
    EXPECT_EQ(sensors_.list("default", {}).items.size(), 1U);
    EXPECT_THAT(sensors_.list("another", {}).items, IsEmpty());
    EXPECT_THROW(sensors_.get("nobody"), Error);
}

TEST_F(SensorStoreTest, AMessageThatComesAgainChangesNothing) {
    send("a", {status(0, 1000, {{"battery", 0.8}})});
    const Sensor before = sensors_.get("aqua");
    const SensorAnswer again = send("a", {status(0, 9000, {{"battery", 0.1}})});
    EXPECT_EQ(again.num_repeated, 1);
    EXPECT_EQ(again.num_new, 0);
    EXPECT_EQ(sensors_.get("aqua").status, before.status);
    EXPECT_EQ(times(now_ms() - 20'000, now_ms() + 20'000).size(), 1U);
}

TEST_F(SensorStoreTest, WhatIsHistoricalOrOlderNeverBecomesWhatIsShown) {
    send("a", {status(5, 5000, {{"depth_m", 5.0}})});
    send("a", {historical(status(6, 6000, {{"depth_m", 6.0}}))});
    EXPECT_EQ(sensors_.get("aqua").status.at("depth_m"), 5.0);
    const SensorAnswer late = send("a", {status(3, 3000, {{"depth_m", 3.0}})});
    EXPECT_EQ(sensors_.get("aqua").status.at("depth_m"), 5.0) << "overtaken on the way";
    EXPECT_EQ(late.acknowledged, -1);
    ASSERT_EQ(late.gaps.size(), 2U);
    EXPECT_EQ(late.gaps[0].last, 2);
    EXPECT_EQ(late.gaps[1].first, 4);
    send("a",
         {historical(status(0, 1)),
          historical(status(1, 2)),
          historical(status(2, 3)),
          historical(status(4, 4))});
    EXPECT_EQ(sensors_.get("aqua").received.acknowledged(), 6);
}

TEST_F(SensorStoreTest, WhatComesLateIsWhereItBelongsWhateverTheDevicesClockSays) {
    SensorMessage live = status(60, 60'000);
    live.time_ms = 4'070'908'800'000;  // the year 2099
    std::vector<SensorMessage> backlog = {live};
    for (std::int64_t i = 0; i < 60; ++i) backlog.push_back(historical(status(i, 1000 * i)));
    std::shuffle(backlog.begin(), backlog.end(), std::mt19937(3));
    send("a", backlog);
    const std::int64_t now = now_ms();
    const auto found = times(now - 100'000, now + 1000);
    ASSERT_EQ(found.size(), 61U);
    for (std::size_t i = 1; i < found.size(); ++i) EXPECT_EQ(found[i] - found[i - 1], 1000);
    EXPECT_NEAR(static_cast<double>(found.back()), static_cast<double>(now), 1000.0);
}

TEST_F(SensorStoreTest, UsesTheDevicesClockForAnEarlierBootUnlessItIsAbsurd) {
    const std::int64_t hour_ago_ms = now_ms() - 3'600'000;
    SensorMessage dated = historical(status(0, 5000));
    dated.time_ms = hour_ago_ms;
    SensorMessage absurd = historical(status(1, 6000));
    absurd.time_ms = 4'070'908'800'000;
    send("old", {dated, absurd});
    EXPECT_EQ(times(hour_ago_ms - 5, hour_ago_ms + 5).size(), 1U);
    const std::int64_t now = now_ms();
    EXPECT_EQ(times(now - 5000, now + 5000).size(), 1U);
    EXPECT_EQ(sensors_.get("aqua").status_at_ms, 0) << "nothing of now came";
}

TEST_F(SensorStoreTest, TheBootThatCameLastSpeaksAndATwinIsTold) {
    send("a", {status(0, 1000, {{"depth_m", 1.0}})});
    send("b", {status(0, 100, {{"depth_m", 2.0}})});
    EXPECT_EQ(sensors_.get("aqua").boot_id, "b") << "it was started again";
    EXPECT_THAT(sensors_.get("aqua").alarms, IsEmpty());

    const SensorAnswer twin = send("a", {status(1, 2000, {{"depth_m", 3.0}})});
    EXPECT_TRUE(twin.superseded);
    EXPECT_EQ(twin.acknowledged, 1) << "and yet it is kept";
    const Sensor sensor = sensors_.get("aqua");
    EXPECT_EQ(sensor.status.at("depth_m"), 2.0);
    ASSERT_EQ(sensor.alarms.size(), 1U);
    EXPECT_EQ(sensor.alarms[0].name, "twin");

    pass(61'000);
    EXPECT_THAT(sensors_.get("aqua").alarms, IsEmpty());
    EXPECT_THAT(told(), ElementsAre("online", "twin raised", "twin over", "idle"));
}

TEST_F(SensorStoreTest, TheBacklogOfAnEarlierBootIsNoTwin) {
    send("b", {status(0, 100, {{"depth_m", 2.0}})});
    const SensorAnswer old = send("a", {historical(status(7, 50'000, {{"depth_m", 9.0}}))});
    EXPECT_TRUE(old.superseded);
    EXPECT_EQ(sensors_.get("aqua").boot_id, "b");
    EXPECT_THAT(sensors_.get("aqua").alarms, IsEmpty());
}

TEST_F(SensorStoreTest, AlarmsAreToldWhenTheyBeginAndEnd) {
    send("a", {status(0, 1000, {{"battery", 0.9}})});
    send("a", {status(1, 2000, {{"battery", 0.19}})});
    send("a", {status(2, 3000, {{"battery", 0.18}})});
    EXPECT_EQ(sensors_.get("aqua").summary, Summary::Attention);
    send("a", {status(3, 4000, {{"battery", 0.05}, {"leak", true}})});
    EXPECT_EQ(sensors_.get("aqua").summary, Summary::Stop);
    send("a", {status(4, 5000, {{"battery", 0.9}})});
    EXPECT_THAT(told(),
                ElementsAre("online",
                            "battery raised",
                            "leak raised",
                            "battery raised",  // worse
                            "leak over",
                            "battery over"));
}

TEST_F(SensorStoreTest, AMetricThatOscillatesAboutItsLimitRaisesOneAlarm) {
    for (int i = 0; i < 40; ++i)
        send("a", {status(i, 1000 * i, {{"battery", i % 2 == 0 ? 0.201 : 0.199}})});
    EXPECT_THAT(told(), ElementsAre("online", "battery raised"));
    send("a", {status(40, 40'000, {{"battery", 0.23}})});
    EXPECT_THAT(sensors_.get("aqua").alarms, IsEmpty());
}

TEST_F(SensorStoreTest, SilenceMeansWhatThePlanSays) {
    send("a", {status(0, 1000)});
    pass(20'000);
    EXPECT_EQ(sensors_.get("aqua").state, SensorState::Idle) << "no dive was announced";
    EXPECT_TRUE(sensors_.get("aqua").stale);
    send("a", {status(1, 30'000, {{"dive_plan", {{"back_in_s", 60}}}})});
    pass(20'000);
    EXPECT_EQ(sensors_.get("aqua").state, SensorState::Submerged);
    EXPECT_EQ(sensors_.get("aqua").summary, Summary::Ok);
    pass(50'000);
    EXPECT_EQ(sensors_.get("aqua").state, SensorState::Overdue);
    EXPECT_EQ(sensors_.get("aqua").summary, Summary::Stop);
    pass(3'600'000);
    EXPECT_EQ(sensors_.get("aqua").state, SensorState::Lost);
    send("a", {status(2, 40'000)});
    EXPECT_EQ(sensors_.get("aqua").state, SensorState::Online);
    EXPECT_THAT(told(),
                ElementsAre("online",
                            "idle",
                            "online",
                            "submerged",
                            "overdue raised",
                            "overdue",
                            "lost",
                            "overdue over",
                            "online"));
}

TEST_F(SensorStoreTest, ASensorIsOfOneProjectAndOthersOfATransactionAreNotTouched) {
    send("a", {status(0, 1000)});
    const auto outcomes = sensors_.receive({{"aqua", "another", {"x", {status(0, 1)}, {}}},
                                            {"fresh", "another", {"x", {status(0, 1)}, {}}}});
    ASSERT_TRUE(outcomes.at(0).failure);
    EXPECT_EQ(outcomes[0].failure->code(), ErrorCode::Conflict);
    EXPECT_FALSE(outcomes.at(1).failure);
    EXPECT_EQ(sensors_.get("aqua").boot_id, "a");
    EXPECT_EQ(sensors_.get("fresh").project, "another");
}

TEST_F(SensorStoreTest, WhatADeviceHasLostIsAcknowledged) {
    send("a", {status(10, 10'000)});
    const auto outcomes = sensors_.receive({{"aqua", "default", {"a", {}, {{0, 9}}}}});
    EXPECT_EQ(outcomes.at(0).answer.acknowledged, 10);
    EXPECT_EQ(outcomes.at(0).answer.num_lost, 10);
}

TEST_F(SensorStoreTest, ALostMessageThatArrivesLaterIsKeptOnce) {
    send("a", {status(10, 10'000)});
    sensors_.receive({{"aqua", "default", {"a", {}, {{0, 9}}}}});
    EXPECT_EQ(send("a", {historical(status(4, 4'000))}).num_new, 1);
    EXPECT_EQ(send("a", {historical(status(4, 4'000))}).num_repeated, 1);
    EXPECT_EQ(sensors_.get("aqua").received.num_lost(), 9);
    const std::int64_t now = now_ms();
    EXPECT_EQ(times(now - 8'000, now + 1).size(), 2U);
}

TEST_F(SensorStoreTest, ThinnedHistoryHasThePeaksAndMeansOfTheWhole) {
    std::mt19937 random(5);
    std::vector<SensorMessage> messages;
    std::vector<double> depths;
    for (int i = 0; i < 1000; ++i) {
        depths.push_back(static_cast<double>(random() % 1000) / 10.0);
        json body = {{"depth_m", depths.back()}};
        if (i == 617) body["leak"] = true;
        messages.push_back(historical(status(i, 1000 * i, body)));
    }
    messages.push_back(status(1000, 1'000'000));
    send("a", messages);
    const std::int64_t boot_ms = sensors_.get("aqua").status_at_ms - 1'000'000;
    const HistoryRequest request{"aqua", boot_ms, boot_ms + 1'000'000, 10, {"depth_m", "leak"}};
    const SensorHistory history = read_history(catalog_, request);
    ASSERT_EQ(history.step_ms, 100'000);
    ASSERT_EQ(history.steps.size(), 10U);
    for (std::size_t i = 0; i < 10; ++i) {
        const auto& step = history.steps[i];
        EXPECT_EQ(step.time_ms, boot_ms + static_cast<std::int64_t>(i) * 100'000);
        EXPECT_EQ(step.num_statuses, 100);
        const auto first = depths.begin() + static_cast<std::ptrdiff_t>(100 * i);
        const auto& depth = step.values.at(0).value();
        EXPECT_EQ(depth.min, *std::min_element(first, first + 100));
        EXPECT_EQ(depth.max, *std::max_element(first, first + 100));
        EXPECT_NEAR(depth.mean, std::accumulate(first, first + 100, 0.0) / 100.0, 1e-9);
        EXPECT_EQ(step.values.at(1).has_value(), i == 6);
    }
    EXPECT_EQ(history.steps[6].values[1]->max, 1.0);
    EXPECT_THROW(read_history(catalog_, {"aqua", 0, 10, 10, {"battery; DROP TABLE"}}), Error);
    EXPECT_THROW(read_history(catalog_, {"aqua", 10, 10, 10, {}}), Error);
}

TEST_F(SensorStoreTest, ForgetsWhatIsTooOldAndNothingElse) {
    SensorMessage old = historical(status(0, 1));
    old.time_ms = now_ms() - 3'600'000;
    send("gone", {old});
    send("a", {status(0, 1000)});
    EXPECT_TRUE(sensors_.forget_older_than(std::chrono::minutes(30)));
    EXPECT_EQ(times(now_ms() - 10'000, now_ms() + 1).size(), 1U);
    EXPECT_THAT(times(*old.time_ms - 5, *old.time_ms + 5), IsEmpty());
}

TEST_F(SensorStoreTest, ADeviceThatMakesUpBootsTakesNoRoomWithoutEnd) {
    std::vector<IncomingReport> reports;
    for (int i = 0; i < 1200; ++i)
        reports.push_back({"aqua", "default", {"boot-" + std::to_string(i), {status(0, 1)}, {}}});
    sensors_.receive(reports);
    int num_boots = 0;
    catalog_.read([&](soci::session& session) {
        session << "SELECT COUNT(*) FROM sensor_boots", soci::into(num_boots);
    });
    EXPECT_EQ(num_boots, 1000);
    EXPECT_EQ(sensors_.get("aqua").boot_id, "boot-1199");
    for (int i = 0; i < 1200; ++i)
        reports[static_cast<std::size_t>(i)].report = {
            "old-" + std::to_string(i), {historical(status(0, 1))}, {}};
    sensors_.receive(reports);
    EXPECT_EQ(sensors_.get("aqua").boot_id, "boot-1199") << "what is shown is not forgotten";
    EXPECT_EQ(send("boot-1199", {status(0, 1)}).num_repeated, 1);
}

TEST_F(SensorStoreTest, TheHistoryHasAColumnForEveryField) {
    catalog_.read([&](soci::session& session) {
        for (const StatusField& field : kStatusFields)
            session << "SELECT " << std::string(field.name) << " FROM sensor_statuses LIMIT 0";
    });
}

}  // namespace
}  // namespace divemesh::storage
