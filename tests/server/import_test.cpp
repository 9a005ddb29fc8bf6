#include <algorithm>
#include <fstream>
#include <sys/stat.h>
#include <unistd.h>

#include "storage/event_store.hpp"
#include "tests/server/tus_fixture.hpp"

namespace divemesh {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

void write(const fs::path& path, const std::string& text) {
    fs::create_directories(path.parent_path());
    std::ofstream(path, std::ios::binary) << text;
}

// A folder as it comes home on a disk, and servers that take it.
class ImportTest : public testing::Test {
protected:
    server::ServerConfig config(const std::string& name = "disk") const {
        server::ServerConfig config;
        config.import_folder = home / name;
        return config;
    }
    // Names of the dives, once there are that many.
    static std::vector<std::string> dives(TestServer& server, std::size_t count) {
        nlohmann::json items;
        for (int i = 0; i < 500 && items.size() < count; ++i) {
            std::this_thread::sleep_for(10ms);
            items = server.request("GET", "/api/v1/dives", server.admin()).json()["items"];
        }
        std::vector<std::string> names;
        for (const auto& item : items) names.push_back(item["name"]);
        std::sort(names.begin(), names.end());
        return names;
    }

    // What was noted of the import: the names, as they come.
    static std::vector<std::string> audits(TestServer& server) {
        std::vector<std::string> names;
        for (const Event& event : storage::EventStore(server.catalog()).since(0, "", 1000))
            if (event.topic == "audit" && event.data["token_name"] == "serve --import")
                names.push_back(event.data["path"]);
        return names;
    }

    static nlohmann::json dive(TestServer& server, const std::string& name) {
        const auto items = server.request("GET", "/api/v1/dives", server.admin()).json()["items"];
        for (const auto& item : items)
            if (item["name"] == name) return item;
        return {};
    }

    TemporaryFolder home;
    const std::string archive = random_bytes(200'000);
};

TEST_F(ImportTest, TakesArchivesAndDiveFoldersAndTouchesNothing) {
    write(home / "disk/wreck.zip", archive);
    write(home / "disk/reef/mav0/cam0/data.csv", "1,1.png\n");
    write(home / "disk/reef/mav0/cam1/data.csv", "1,1.png\n");
    write(home / "disk/notes.txt", "no dive");
    TestServer server(config());
    EXPECT_EQ(dives(server, 2), (std::vector<std::string>{"reef.tar", "wreck.zip"}));
    const auto stored = dive(server, "wreck.zip");
    EXPECT_EQ(stored["archive_sha256"], sha256_hex(archive));
    EXPECT_EQ(stored["state"], "checking") << "its intake job will open it";
    EXPECT_EQ(audits(server),
              (std::vector<std::string>{"reef.tar", "reef.tar", "wreck.zip", "wreck.zip"}))
        << "each time the upload and the dive";
    EXPECT_TRUE(fs::exists(home / "disk/wreck.zip"));
    EXPECT_TRUE(fs::exists(home / "disk/reef/mav0/cam0/data.csv"));
}

TEST_F(ImportTest, TheFolderMayBeADiveItselfAndMayBeReconstructed) {
    write(home / "disk/mav0/cam0/data.csv", "1,1.png\n");
    auto wanted = config();
    wanted.import_project = "reef";
    wanted.import_preset = "fast";
    TestServer server(wanted);
    EXPECT_EQ(dives(server, 1), std::vector<std::string>{"disk.tar"});
    const auto jobs =
        server.request("GET", "/api/v1/jobs?kind=reconstruct", server.admin()).json()["items"];
    ASSERT_EQ(jobs.size(), 1U);
    EXPECT_EQ(jobs[0]["preset"], "fast");
    EXPECT_EQ(jobs[0]["project"], "reef");
}

TEST_F(ImportTest, ADiveThatIsThereTwiceIsOne) {
    write(home / "disk/a.tar", archive);
    write(home / "disk/b.tar", archive);
    write(home / "disk/c.tar", archive + "more");
    TestServer server(config());
    EXPECT_EQ(dives(server, 2), (std::vector<std::string>{"a.tar", "c.tar"}));
}

TEST_F(ImportTest, LinksAndSpecialFilesLeadNowhere) {
    write(home / "disk10/outside.tar", archive);
    write(home / "disk/real.tar", archive + "1");
    fs::create_symlink(home / "disk10/outside.tar", home / "disk/link.tar");
    fs::create_symlink(home / "disk10", home / "disk/folder");
    fs::create_hard_link(home / "disk10/outside.tar", home / "disk/hard.tar");
    ASSERT_EQ(mkfifo((home / "disk/pipe.tar").c_str(), 0600), 0);
    write(home / "disk/dive/mav0/cam0/data.csv", "1,1.png\n");
    fs::create_symlink(home / "disk10", home / "disk/dive/mav0/cam1");
    fs::create_symlink("/etc/passwd", home / "disk/dive/mav0/cam0/data.png");
    write(home / "disk/twin/mav0/cam0/data.csv", "2,2.png\n");
    fs::create_directories(home / "disk/twin/mav0/cam1");
    fs::create_hard_link(home / "disk10/outside.tar", home / "disk/twin/mav0/cam1/data.csv");
    write(home / "disk/..x\n\x1b[31m.tar", archive + "2");
    TestServer server(config());
    const auto names = dives(server, 3);
    EXPECT_EQ(names, (std::vector<std::string>{"..x[31m.tar", "dive.tar", "real.tar"}));
    for (const auto& name : names)
        EXPECT_NE(dive(server, name)["archive_sha256"], sha256_hex(archive)) << name;
    EXPECT_LT(dive(server, "dive.tar")["archive_bytes"], 10'000)
        << "what the links lead to is not in it";
}

}  // namespace
}  // namespace divemesh
