#include "sensor/commands/command_executor.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <thread>

#include "tests/temporary_folder.hpp"

namespace divemesh::sensor {
namespace {

using nlohmann::json;

constexpr std::int64_t kServer_ms = 1'700'000'000'000;

class CommandExecutorTest : public testing::Test {
protected:
    CommandSettings settings() {
        CommandSettings settings;
        settings.journal = folder_ / "state" / "commands.json";
        settings.allow_set_clock = true;
        settings.make_preview = [this](const json&) {
            ++num_previews_;
            return std::string();
        };
        settings.uptime_ms = [this] { return uptime_ms_; };
        settings.set_clock = [this](std::int64_t time_ms) {
            clock_ms_ = time_ms;
            return std::string();
        };
        return settings;
    }
    // A program that writes down what it is asked to do.
    std::string program(const std::string& body) {
        const auto path = folder_ / "program";
        std::ofstream(path) << "#!/bin/sh\n" << body << "\n";
        std::filesystem::permissions(path, std::filesystem::perms::owner_all);
        return path.string();
    }
    Command command(const std::string& id, const std::string& name, std::int64_t life_ms = 60'000) {
        Command command;
        command.id = id;
        command.name = name;
        // Asked for at 1000 ms, the welcome came at 1200.
        command.server_time = {kServer_ms, 1'000, 1'200};
        command.came_at_uptime_ms = uptime_ms_;
        command.expires_at_ms = kServer_ms + (uptime_ms_ - 1'000) + life_ms;
        return command;
    }
    static json work(CommandExecutor& executor) {
        json outcomes = json::array();
        for (int i = 0; i < 300 && outcomes.empty(); ++i) {
            for (const json& outcome : executor.work()) outcomes.push_back(outcome);
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
        }
        return outcomes;
    }
    std::string asked() {
        std::ifstream stream(folder_ / "asked");
        return {std::istreambuf_iterator<char>(stream), {}};
    }

    TemporaryFolder folder_;
    std::int64_t uptime_ms_ = 5'000;
    std::int64_t clock_ms_ = 0;
    int num_previews_ = 0;
};

TEST_F(CommandExecutorTest, OffersWhatItCanDo) {
    CommandSettings plain = settings();
    plain.allow_set_clock = false;
    EXPECT_EQ(CommandExecutor(plain).capabilities(), std::vector<std::string>{"preview"});
    CommandSettings all = settings();
    all.on_command = "/bin/true";
    EXPECT_EQ(
        CommandExecutor(all).capabilities(),
        (std::vector<std::string>{"preview", "start_recording", "stop_recording", "set_clock"}));
}

TEST_F(CommandExecutorTest, StartsTheProgramWithWhatIsAsked) {
    CommandSettings with_program = settings();
    with_program.on_command = program("echo $1 >> " + (folder_ / "asked").string());
    CommandExecutor executor(with_program);
    executor.take(command("a", "start_recording"));
    EXPECT_EQ(work(executor), json::parse(R"([{"command": "a", "state": "done"}])"));
    EXPECT_EQ(asked(), "start_recording\n");
}

TEST_F(CommandExecutorTest, TellsHowTheProgramFailed) {
    CommandSettings with_program = settings();
    with_program.on_command = program("exit 3");
    CommandExecutor executor(with_program);
    executor.take(command("a", "stop_recording"));
    const json outcomes = work(executor);
    EXPECT_EQ(outcomes[0]["state"], "failed");
    EXPECT_EQ(outcomes[0]["detail"], "it ended with exit code 3");
}

TEST_F(CommandExecutorTest, EndsAProgramThatTakesTooLong) {
    CommandSettings with_program = settings();
    with_program.on_command = program("sleep 60");
    with_program.program_time = std::chrono::milliseconds(100);
    CommandExecutor executor(with_program);
    executor.take(command("a", "stop_recording"));
    EXPECT_EQ(work(executor)[0]["state"], "failed");
}

TEST_F(CommandExecutorTest, CarriesOutNothingLate) {
    CommandExecutor executor(settings());
    Command late = command("a", "preview", 1'000);
    uptime_ms_ += 1'000;  // by the latest that it may be there; by the welcome alone it is not
    executor.take(late);
    EXPECT_EQ(work(executor)[0]["state"], "expired");
    EXPECT_EQ(num_previews_, 0);
    Command in_time = command("b", "preview", 1'001);
    uptime_ms_ += 1'000;
    executor.take(in_time);
    EXPECT_EQ(work(executor)[0]["state"], "done");
}

TEST_F(CommandExecutorTest, CarriesOutNothingThatBecameLateWhileItWaited) {
    CommandSettings with_program = settings();
    with_program.on_command = program("echo $1 >> " + (folder_ / "asked").string() + "; sleep 0.1");
    CommandExecutor executor(with_program);
    executor.take(command("a", "start_recording"));
    executor.take(command("b", "stop_recording", 1'000));
    EXPECT_TRUE(executor.work().empty());
    uptime_ms_ += 2'000;
    const json outcomes = work(executor);
    ASSERT_EQ(outcomes.size(), 2u);
    EXPECT_EQ(outcomes[1]["state"], "expired");
    EXPECT_EQ(asked(), "start_recording\n");
}

TEST_F(CommandExecutorTest, CarriesOutOnceWhatComesTwice) {
    CommandExecutor executor(settings());
    executor.take(command("a", "preview"));
    executor.take(command("a", "preview"));
    EXPECT_EQ(work(executor).size(), 1u);
    executor.take(command("a", "preview"));
    EXPECT_EQ(work(executor)[0]["state"], "done");  // said again, not done again
    EXPECT_EQ(num_previews_, 1);
}

TEST_F(CommandExecutorTest, KnowsAfterAStartWhatItDidBefore) {
    {
        CommandExecutor executor(settings());
        executor.take(command("a", "preview"));
        work(executor);
    }
    CommandExecutor executor(settings());
    executor.take(command("a", "preview"));
    EXPECT_EQ(work(executor)[0]["state"], "done");
    EXPECT_EQ(num_previews_, 1);
}

TEST_F(CommandExecutorTest, DoesNotRepeatACommandInterruptedByPowerLoss) {
    CommandJournal(folder_ / "state" / "commands.json").note({"a", "begun", ""});
    CommandExecutor executor(settings());
    executor.take(command("a", "preview"));
    EXPECT_EQ(work(executor)[0]["state"], "failed");
    EXPECT_EQ(num_previews_, 0);
}

TEST_F(CommandExecutorTest, DoesNotStartWhatItCannotNote) {
    std::ofstream(folder_ / "state") << "no folder";
    CommandSettings with_program = settings();
    with_program.on_command = program("echo $1 >> " + (folder_ / "asked").string());
    CommandExecutor executor(with_program);
    executor.take(command("a", "start_recording"));
    EXPECT_EQ(work(executor)[0]["state"], "failed");
    EXPECT_EQ(asked(), "");
}

TEST_F(CommandExecutorTest, RefusesWhatItDoesNotOffer) {
    CommandExecutor executor(settings());
    executor.take(command("a", "start_recording"));
    EXPECT_EQ(work(executor)[0]["state"], "refused");
    executor.take(command("b", "explode"));
    EXPECT_EQ(work(executor)[0]["state"], "refused");
}

TEST_F(CommandExecutorTest, SetsTheClockToWhatItIsByNow) {
    CommandExecutor executor(settings());
    Command set = command("a", "set_clock");
    set.arguments = {{"time_ms", kServer_ms}};
    uptime_ms_ += 700;
    executor.take(set);
    EXPECT_EQ(work(executor)[0]["state"], "done");
    EXPECT_EQ(clock_ms_, kServer_ms + 700);
    executor.take(command("b", "set_clock"));
    EXPECT_EQ(work(executor)[0]["state"], "failed");
}

TEST_F(CommandExecutorTest, TakesAJournalThatIsDamaged) {
    std::filesystem::create_directories(folder_ / "state");
    std::ofstream(folder_ / "state" / "commands.json") << "[{\"id\": 7}, {\"id\": \"a\", ";
    CommandExecutor executor(settings());
    executor.take(command("a", "preview"));
    EXPECT_EQ(work(executor)[0]["state"], "done");
}

}  // namespace
}  // namespace divemesh::sensor
