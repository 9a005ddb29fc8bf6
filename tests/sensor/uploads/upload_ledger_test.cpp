#include "sensor/uploads/upload_ledger.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "tests/temporary_folder.hpp"

namespace divemesh::sensor {
namespace {

using State = UploadLedger::State;
using Dives = std::vector<std::filesystem::path>;

class UploadLedgerTest : public testing::Test {
protected:
    std::filesystem::path dive(const std::string& name) {
        std::filesystem::create_directories(folder_ / name);
        return folder_ / name;
    }
    TemporaryFolder folder_;
    std::filesystem::path file_ = folder_ / "state" / "uploads.json";
};

TEST_F(UploadLedgerTest, KnowsAfterAStartWhatItKnewBefore) {
    {
        UploadLedger ledger(file_);
        EXPECT_FALSE(ledger.has_begun());
        ledger.begin({dive("old")});
        ledger.note(dive("cut short"), State::Open);
        ledger.note(dive("over"), State::Over);
        ledger.note_sent(dive("sent"), "server hash");
        ledger.note(dive("sent"), State::Over);
    }
    const UploadLedger ledger(file_);
    EXPECT_TRUE(ledger.has_begun());
    EXPECT_EQ(ledger.all(State::Old), Dives{dive("old")});
    EXPECT_EQ(ledger.all(State::Open), Dives{dive("cut short")});
    EXPECT_EQ(ledger.all(State::Over), (Dives{dive("over"), dive("sent")}));
    EXPECT_EQ(ledger.find(dive("sent"))->sent, "server hash");
    EXPECT_EQ(ledger.find(dive("another")), std::nullopt);
}

TEST_F(UploadLedgerTest, ForgetsDivesThatAreGoneAndOweNothing) {
    UploadLedger ledger(file_);
    ledger.begin({folder_ / "gone"});
    ledger.note(folder_ / "on a disk that is not there", State::Over);
    EXPECT_TRUE(ledger.all(State::Old).empty());
    EXPECT_EQ(ledger.all(State::Over).size(), 1u);
}

TEST_F(UploadLedgerTest, BeginsAnewWhereItsFileIsDamaged) {
    std::filesystem::create_directories(file_.parent_path());
    for (const char* text : {"", "{\"/a\": {\"state\": \"ov", "[1, 2]", "\xFF\xFE"}) {
        std::ofstream(file_, std::ios::trunc) << text;
        EXPECT_FALSE(UploadLedger(file_).has_begun()) << text;
    }
    std::ofstream(file_, std::ios::trunc) << R"({"/a": 7, "/b": {"state": 1}, "/c": {"state": "?"},
        "/d": {"state": "over", "sent": []}})";
    EXPECT_EQ(UploadLedger(file_).all(State::Over), Dives{"/d"});
}

TEST_F(UploadLedgerTest, ReportsThatItsFileCannotBeWritten) {
    std::ofstream(folder_ / "state") << "no folder";
    UploadLedger ledger(file_);
    ledger.note(dive("over"), State::Over);
    EXPECT_NE(ledger.trouble(), "");
    EXPECT_EQ(ledger.all(State::Over).size(), 1u);
}

}  // namespace
}  // namespace divemesh::sensor
