// ?fields=: what is left of objects and lists. Each answer is held against the contract, which
// then allows the named fields alone (tests/server/contract.cpp).
#include "storage/worker_store.hpp"
#include "tests/server/tus_fixture.hpp"

namespace divemesh {
namespace {

class FieldsTest : public TusTest {
protected:
    RawResponse get(const std::string& target, const Headers& headers = {}) {
        return server.request("GET", target, token, headers);
    }
    static std::string joined(const std::vector<std::string>& keys) {
        std::string list;
        for (const std::string& key : keys) list += (list.empty() ? "" : ",") + key;
        return list;
    }
    static std::vector<std::string> keys_of(const nlohmann::json& object) {
        std::vector<std::string> keys;
        for (const auto& [key, value] : object.items()) keys.push_back(key);
        return keys;
    }
    std::string new_webhook() {
        const auto made =
            server.post_json("/api/v1/webhooks", token, {{"url", "https://example.org/"}});
        EXPECT_EQ(made.status, 201) << made.body;
        return made.json()["id"];
    }
};

using Keys = std::vector<std::string>;

TEST_F(FieldsTest, AnObjectHasTheNamedOnesAlone) {
    const auto dive = "/api/v1/dives/" + server.make_dive("default", std::string(64, 'a'));
    const auto whole = get(dive).json();
    const auto some = get(dive + "?fields=state,id,tags").json();
    EXPECT_EQ(keys_of(some), (Keys{"id", "state", "tags"}));
    for (const auto& [key, value] : some.items()) EXPECT_EQ(value, whole[key]) << key;
    EXPECT_EQ(keys_of(get(dive + "?fields=id,id").json()), Keys{"id"});
}

TEST_F(FieldsTest, EveryListAndObjectThatSaysSoTakesThem) {
    const auto job = "/api/v1/jobs/" + server.make_job("default", "mesh.glb", "glTF");
    const auto dive = "/api/v1/dives/" + get(job).json()["dive_id"].get<std::string>();
    storage::WorkerStore(server.catalog()).report("boat:1", 1);
    const auto webhook = "/api/v1/webhooks/" + new_webhook();
    EXPECT_EQ(server.post_json(job + "/shares", token, {{"name", "reviewers"}}).status, 201);
    server.request("DELETE", dive, token, {{"If-Match", "*"}});  // leaves a delivery
    const std::pair<std::string, Keys> objects[] = {
        {create_upload(server.port(), token, 10), {"id", "offset_bytes"}},
        {dive, {"id", "name"}},
        {job, {"forecast", "progress"}},
        {"/api/v1/queue", {"num_jobs", "paused"}}};
    const std::pair<std::string, Keys> lists[] = {{"/api/v1/dives?deleted=true&", {"id", "name"}},
                                                  {"/api/v1/jobs?", {"failure", "id"}},
                                                  {job + "/attempts?", {"number", "state"}},
                                                  {job + "/artifacts?", {"name", "sha256"}},
                                                  {"/api/v1/workers?", {"alive", "name"}},
                                                  {job + "/shares?", {"id", "withdrawn"}},
                                                  {"/api/v1/tokens?", {"id", "scopes"}},
                                                  {"/api/v1/webhooks?", {"id", "url"}},
                                                  {webhook + "/deliveries?", {"id", "state"}}};
    for (const auto& [path, keys] : objects)
        EXPECT_EQ(keys_of(get(path + "?fields=" + joined(keys)).json()), keys) << path;
    for (const auto& [path, keys] : lists) {
        const auto items =
            get(path + "fields=" + joined({keys.rbegin(), keys.rend()})).json()["items"];
        ASSERT_FALSE(items.empty()) << path;
        for (const auto& item : items) EXPECT_EQ(keys_of(item), keys) << path;
    }
}

TEST_F(FieldsTest, AnUnknownFieldIsRefusedByItsName) {
    const auto dive = "/api/v1/dives/" + server.make_dive("default", std::string(64, 'a'));
    for (const auto& path : {dive, std::string("/api/v1/dives"), dive + "/findings"}) {
        const auto refused = get(path + "?fields=id,colour");
        EXPECT_EQ(refused.status, 400) << path;
        const auto detail = refused.json()["detail"].get<std::string>();
        EXPECT_NE(detail.find(path.ends_with("findings") ? "\"id\"" : "\"colour\""),
                  std::string::npos)
            << detail;
    }
    for (const char* fields : {"", ",", "id,", "id,,name", "ID", "blob", "id%2Cname%20"})
        EXPECT_EQ(get(dive + "?fields=" + fields).status, 400) << fields;
}

TEST_F(FieldsTest, TheNextPageHasThemToo) {
    for (int i = 0; i < 3; ++i) server.make_dive("default", sha256_hex(std::to_string(i)));
    const auto first = get("/api/v1/dives?fields=archive_sha256&limit=2");
    const auto link = first.header("link");
    const auto second = get(link.substr(1, link.find('>') - 1)).json();
    ASSERT_EQ(second["items"].size(), 1U);
    EXPECT_EQ(second["items"][0], nlohmann::json({{"archive_sha256", sha256_hex("2")}}));
}

TEST_F(FieldsTest, TheirTagIsOfWhatIsAnswered) {
    const auto dive = "/api/v1/dives/" + server.make_dive("default", std::string(64, 'a'));
    const auto some = get(dive + "?fields=id").header("etag");
    EXPECT_EQ(get(dive + "?fields=id", {{"If-None-Match", some}}).status, 304);
    EXPECT_EQ(get(dive, {{"If-None-Match", some}}).status, 200);
    EXPECT_EQ(server.request("DELETE", dive, token, {{"If-Match", some}}).status, 412);
}

}  // namespace
}  // namespace divemesh
