#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <stdexcept>
#include <yaml-cpp/yaml.h>

#include "api/openapi_document.hpp"
#include "api/routes.hpp"
#include "schemas/artifact.hpp"
#include "schemas/json.hpp"
#include "schemas/reconstruction_options.hpp"
#include "schemas/shown_job.hpp"
#include "schemas/wait_reason.hpp"
#include "tests/paths.hpp"

namespace divemesh::api {
namespace {

using Operations = std::set<std::pair<std::string, std::string>>;

std::string lower(std::string text) {
    for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    return text;
}

nlohmann::json document() { return nlohmann::json::parse(openapi_json()); }

std::set<std::string> keys_of(const nlohmann::json& object) {
    std::set<std::string> keys;
    for (const auto& [key, value] : object.items()) keys.insert(key);
    return keys;
}

template <typename Range>
std::set<std::string> words_of(const Range& values) {
    std::set<std::string> words;
    for (const auto& value : values) words.insert(std::string(to_string(value)));
    return words;
}

// Returns the words of an enum that counts up from 0: to_string() throws past the last value.
template <typename Enum>
std::set<std::string> words_of_enum() {
    std::set<std::string> words;
    try {
        for (int value = 0;; ++value)
            words.insert(std::string(to_string(static_cast<Enum>(value))));
    } catch (const std::logic_error&) {
        return words;
    }
}

TEST(ContractTest, DocumentsExactlyTheRoutesThatAreServed) {
    Operations served;
    for (const Route& route : api_routes()) {
        std::string path(route.path);
        if (const auto dots = path.find("...}"); dots != std::string::npos) path.erase(dots, 3);
        served.emplace(path, lower(std::string(http::to_string(route.method))));
    }
    Operations documented;
    const auto paths = document()["paths"];
    for (const auto& [path, item] : paths.items())
        for (const auto& [method, operation] : item.items())
            if (method != "parameters") documented.emplace(path, method);
    EXPECT_EQ(documented, served);
}

TEST(ContractTest, SaysWhichRoutesNeedNoToken) {
    const auto paths = document()["paths"];
    for (const Route& route : api_routes()) {
        std::string path(route.path);
        if (const auto dots = path.find("...}"); dots != std::string::npos) path.erase(dots, 3);
        const auto operation = paths[path][lower(std::string(http::to_string(route.method)))];
        EXPECT_EQ(operation.value("security", nlohmann::json()) == nlohmann::json::array(),
                  route.scope.empty())
            << path;
    }
}

TEST(ContractTest, DescribesTheKeysThatOurTypesHave) {
    const auto schemas = document()["components"]["schemas"];
    const std::pair<const char*, nlohmann::json> types[] = {{"Upload", Upload{}},
                                                            {"Dive", Dive{}},
                                                            {"Finding", Finding{}},
                                                            {"KnownMetric", KnownMetric{}},
                                                            {"Progress", Progress{}},
                                                            {"Failure", Failure{}},
                                                            {"StageRun", StageRun{}},
                                                            {"Forecast", Forecast{}},
                                                            {"Job", Job{}},
                                                            {"Attempt", Attempt{}},
                                                            {"TruthFile", TruthFile{}},
                                                            {"Schedule", Schedule{}},
                                                            {"Queue", Queue{}},
                                                            {"Worker", Worker{}},
                                                            {"Artifact", Artifact{}},
                                                            {"Event", Event{}},
                                                            {"Share", Share{}},
                                                            {"Token", Token{}},
                                                            {"Webhook", Webhook{}},
                                                            {"WebhookDelivery", WebhookDelivery{}}};
    ShownJob waiting_job;
    waiting_job.waits_for = "disk";
    waiting_job.deleted_at_ms = 1;
    Worker waiting_worker;
    waiting_worker.waits_for = "disk";
    // The types with keys that may be absent, with all of them.
    const std::map<std::string, nlohmann::json> whole = {
        {"Forecast", Forecast{.position = 1, .starts_in_s = 1.0, .takes_s = 1.0}},
        {"Job", waiting_job},
        {"Worker", waiting_worker}};
    for (const auto& [name, value] : types) {
        const auto& all = whole.contains(name) ? whole.at(name) : value;
        EXPECT_EQ(keys_of(schemas[name]["properties"]), keys_of(all)) << name;
        EXPECT_EQ(schemas[name]["required"].get<std::set<std::string>>(), keys_of(value)) << name;
    }
}

TEST(ContractTest, ListsTheWordsThatOurTypesKnow) {
    const auto schemas = document()["components"]["schemas"];
    const auto words = [&](const char* name) {
        return schemas[name]["enum"].get<std::set<std::string>>();
    };
    EXPECT_EQ(words("JobState"), words_of(kJobStates));
    EXPECT_EQ(words("WebhookTopic"),
              std::set<std::string>(kWebhookTopics.begin(), kWebhookTopics.end()));
    EXPECT_EQ(words("Scope"), std::set<std::string>(kScopes.begin(), kScopes.end()));
    EXPECT_EQ(words("Preset"), std::set<std::string>(std::begin(kPresets), std::end(kPresets)));
    EXPECT_EQ(words("AttemptState"), words_of_enum<AttemptState>());
    EXPECT_EQ(words("JobKind"), words_of_enum<JobKind>());
    EXPECT_EQ(words("DiveState"), words_of_enum<DiveState>());
    EXPECT_EQ(words("ErrorCode"), words_of_enum<ErrorCode>());
    EXPECT_EQ(schemas["WaitReason"]["x-extensible-enum"].get<std::set<std::string>>(),
              words_of_enum<WaitReason>());
}

void expect_no_key_by_mistake(const nlohmann::json& node, const std::string& where) {
    if (!node.is_structured()) return;
    for (const auto& [key, value] : node.items()) {
        const std::string here = where + '/' + key;
        EXPECT_FALSE(node.is_object() && value.is_null() && key.find(' ') != std::string::npos)
            << here << ": quote the text with the comma before it";
        expect_no_key_by_mistake(value, here);
    }
}

// In "{ description: one, two }" the words after the comma are a key.
TEST(ContractTest, NoPartOfADescriptionIsAKey) { expect_no_key_by_mistake(document(), ""); }

TEST(ContractTest, EveryReferenceLeadsSomewhere) {
    const auto contract = document();
    const std::function<void(const nlohmann::json&)> follow = [&](const nlohmann::json& node) {
        if (node.is_object() && node.contains("$ref")) {
            const auto target = node["$ref"].get<std::string>();
            EXPECT_TRUE(contract.contains(nlohmann::json::json_pointer(target.substr(1))))
                << target;
        }
        if (node.is_structured())
            for (const auto& child : node) follow(child);
    };
    follow(contract);
    EXPECT_EQ(YAML::LoadFile(source_directory() / "api/openapi.yaml")["paths"].size(),
              contract["paths"].size());
}

}  // namespace
}  // namespace divemesh::api
