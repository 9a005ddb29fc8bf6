// The n-th call of every kind fails, for every n, while one running service takes an upload and
// makes a dive of it: the client is told, what was acknowledged is there, and it goes on from there
// to a dive of the bytes that it sent.
#include <gtest/gtest.h>

#include <array>
#include <boost/beast/http/status.hpp>
#include <nlohmann/json.hpp>

#include "storage/dive_store.hpp"
#include "tests/faults/fault_layer.hpp"
#include "tests/portless_service.hpp"

namespace divemesh::faults {
namespace {

using api::status;
using api::verb;

class UploadSweepTest : public testing::TestWithParam<Call> {
protected:
    // A client of the service that sends one recording. Each request returns whether it was served;
    // what was not says 503, 507, or 409 after an answer that was lost.
    struct Client {
        PortlessService& service;
        std::string recording;
        std::string upload = {};  // its target
        std::size_t num_acknowledged = 0;
        std::string dive_id = {};

        bool create() {
            api::Request request{.method = verb::post, .target = "/api/v1/uploads"};
            request.headers = {{"tus-resumable", "1.0.0"},
                               {"upload-length", std::to_string(recording.size())}};
            const auto answer = service.ask(request, "");
            if (!served(answer)) return false;
            const std::string location = header(answer, "Location");
            upload = location.substr(location.find("/api/"));
            return true;
        }
        bool send(std::size_t from, std::size_t to) {
            api::Request request{.method = verb::patch, .target = upload};
            request.headers = {{"tus-resumable", "1.0.0"},
                               {"upload-offset", std::to_string(from)},
                               {"content-type", "application/offset+octet-stream"},
                               {"content-length", std::to_string(to - from)}};
            const auto answer =
                service.ask(request, std::string_view(recording).substr(from, to - from));
            if (!served(answer)) return false;
            num_acknowledged = std::stoul(header(answer, "Upload-Offset"));
            EXPECT_EQ(num_acknowledged, to);
            return true;
        }
        bool make_dive() {
            api::Request request{.method = verb::post, .target = "/api/v1/dives"};
            request.headers = {{"content-type", "application/json"}};
            const auto answer = service.ask(
                request,
                nlohmann::json{{"upload_id", upload.substr(upload.rfind('/') + 1)}}.dump());
            if (!served(answer)) return false;
            const auto document = nlohmann::json::parse(std::get<std::string>(answer.body));
            dive_id = document.contains("dive") ? document["dive"]["id"] : document["id"];
            return true;
        }
        std::size_t ask_offset() {
            api::Request request{.method = verb::head, .target = upload};
            request.headers = {{"tus-resumable", "1.0.0"}};
            const auto answer = service.ask(request, "");
            EXPECT_TRUE(served(answer));
            return std::stoul(header(answer, "Upload-Offset"));
        }
        bool send_all() {
            return create() && send(0, recording.size() / 2) &&
                   send(recording.size() / 2, recording.size()) && make_dive();
        }

        // Goes on as a client does that was told of an error.
        void resume() {
            if (upload.empty() && !create())
                ADD_FAILURE() << "the service takes no upload any more";
            const std::size_t offset = ask_offset();
            EXPECT_GE(offset, num_acknowledged);
            EXPECT_TRUE(offset == recording.size() || send(offset, recording.size()));
            EXPECT_TRUE(make_dive());
        }

        static std::string header(const api::Response& answer, std::string_view name) {
            for (const auto& [key, value] : answer.headers)
                if (key == name) return value;
            ADD_FAILURE() << "no header " << name;
            return "0";
        }
        static bool served(const api::Response& answer) {
            const auto* text = std::get_if<std::string>(&answer.body);
            const auto code = static_cast<unsigned>(answer.status);
            EXPECT_TRUE(code < 300 || code == 503 || code == 507)
                << code << ' ' << (text ? *text : "");
            return code < 300;
        }
    };

    std::string bytes_of_dive(const std::string& id) {
        const auto reader =
            service_.blobs().open(storage::DiveStore(service_.catalog()).get(id).blob);
        std::string bytes(static_cast<std::size_t>(reader->size_bytes()), '\0');
        bytes.resize(reader->read_at(0, bytes));
        return bytes;
    }

    void sweep(Lasting lasting) {
        bool happened = true;
        for (int number = 1; happened && !HasFailure(); ++number) {
            SCOPED_TRACE("call " + std::to_string(number) +
                         (lasting == Lasting::Once ? "" : " and all later ones"));
            Client client{.service = service_,
                          .recording = std::to_string(num_recordings_++) + std::string(5000, 'r')};
            bool done = false;
            {
                const Armed armed({GetParam(), number, lasting});
                done = client.send_all();
                happened = armed.happened();
            }
            EXPECT_TRUE(done || happened);
            if (!done) client.resume();
            EXPECT_EQ(bytes_of_dive(client.dive_id), client.recording);
        }
    }

    PortlessService service_;
    int num_recordings_ = 0;
};

TEST_P(UploadSweepTest, ARecordingArrivesWhateverFails) {
    sweep(Lasting::Once);
    sweep(Lasting::ForGood);
    int sound = 0;
    service_.catalog().read([&](soci::session& session) {
        session << "SELECT COUNT(*) FROM pragma_integrity_check WHERE integrity_check = 'ok'",
            soci::into(sound);
    });
    EXPECT_EQ(sound, 1);
}

INSTANTIATE_TEST_SUITE_P(Failing,
                         UploadSweepTest,
                         testing::ValuesIn(kCallsOfDisk),
                         [](const auto& sweep) { return std::string(name_of(sweep.param)); });

}  // namespace
}  // namespace divemesh::faults
