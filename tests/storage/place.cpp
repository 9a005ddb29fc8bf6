#include "tests/storage/place.hpp"

#include <gtest/gtest.h>

#include <cstdlib>

#include "schemas/content_hash.hpp"
#include "storage/catalog.hpp"

namespace divemesh::storage {
namespace {

namespace fs = std::filesystem;

constexpr const char* kTemplate = "catalog_template";

std::string name_of(const fs::path& place) {
    return "t_" + sha256_hex(place.lexically_normal().string()).substr(0, 24);
}

// Databases are copies of one, because making the schema takes longer.
void make_database(const std::string& name, const std::string& original) {
    PostgresqlServer& server = postgresql_server();
    if (original == kTemplate && !server.has_database(kTemplate)) {
        server.run(std::string("CREATE DATABASE ") + kTemplate);
        const Catalog catalog(server.url(kTemplate));
    }
    server.run("CREATE DATABASE " + name + " TEMPLATE " + original);
}

class EngineUnderTest : public testing::Environment {
public:
    void SetUp() override {
        if (on_postgresql() && !PostgresqlServer::is_installed())
            GTEST_SKIP() << "PostgreSQL is not installed";
    }
};

[[maybe_unused]] const auto* const kEnvironment =
    testing::AddGlobalTestEnvironment(new EngineUnderTest);

}  // namespace

bool on_postgresql() {
    const char* engine = std::getenv("DIVEMESH_TEST_ENGINE");
    return engine != nullptr && std::string(engine) == "postgresql";
}

PostgresqlServer& postgresql_server() {
    static PostgresqlServer server;
    return server;
}

std::string catalog_url(const fs::path& place) {
    if (!on_postgresql()) return "sqlite://" + (place / "catalog.db").string();
    const std::string name = name_of(place);
    if (!postgresql_server().has_database(name)) make_database(name, kTemplate);
    return postgresql_server().url(name);
}

void copy_place(const fs::path& from, const fs::path& to) {
    fs::copy(from, to, fs::copy_options::recursive);
    if (on_postgresql()) make_database(name_of(to), name_of(from));
}

void remove_catalog(const fs::path& place) {
    if (on_postgresql())
        postgresql_server().run("DROP DATABASE IF EXISTS " + name_of(place) + " WITH (FORCE)");
}

}  // namespace divemesh::storage
