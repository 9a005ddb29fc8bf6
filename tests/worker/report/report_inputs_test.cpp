#include "worker/report/report_inputs.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "schemas/content_hash.hpp"
#include "schemas/error.hpp"
#include "tests/temporary_folder.hpp"

namespace divemesh::report {
namespace {

class ReportInputsTest : public testing::Test {
protected:
    ReportInputsTest() {
        std::filesystem::create_directories(folder_ / "dive/mav0");
        std::filesystem::create_directories(folder_ / "result");
        std::ofstream(folder_ / "dive/mav0/a") << "abc";
        std::ofstream(folder_ / "dive/.DS_Store") << "seen";
        request_.reconstruction = folder_ / "result";
        request_.dive = folder_ / "dive";
        request_.scratch = folder_ / "scratch";
    }

    // Opens the dive for the report on a reconstruction of the dive with this hash.
    void open_as_dive_of(const std::string& content_sha256) {
        const nlohmann::json metrics = {{"dive", {{"content_sha256", content_sha256}}}};
        std::ofstream(folder_ / "result/metrics.json") << metrics;
        read_report_inputs(request_, base::ignore_progress);
    }

    TemporaryFolder folder_;
    AccuracyReportRequest request_;
};

// The digests are what `sha256sum mav0/a | sha256sum` and `sha256sum .DS_Store mav0/a | sha256sum`
// print.
TEST_F(ReportInputsTest, TakesADiveWhoseReconstructionCountedWhatDesktopsLeave) {
    EXPECT_NO_THROW(
        open_as_dive_of("2bdb05d3968c2c2844cf36dfaadc22cbd6d1d31165dd7fc86e937ffee61dd58f"));
    EXPECT_NO_THROW(
        open_as_dive_of("10a6d48fa887e10bf52b76bb556a70010548b7d4300d106fd097082f6789494b"));
}

TEST_F(ReportInputsTest, RefusesAnotherDive) {
    EXPECT_THROW(open_as_dive_of(sha256_hex("something else")), Error);
}

}  // namespace
}  // namespace divemesh::report
