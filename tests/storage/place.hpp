#pragma once

#include <filesystem>
#include <string>

#include "tests/postgresql_server.hpp"
#include "tests/temporary_folder.hpp"

// Where the catalogs of tests are. All store tests run a second time with their catalogs in
// PostgreSQL: DIVEMESH_TEST_ENGINE=postgresql storage_tests --gtest_filter=-Sqlite*
namespace divemesh::storage {

bool on_postgresql();

// Returns the server of this process; starts it if it does not run.
PostgresqlServer& postgresql_server();

// Returns the URL of the catalog that belongs to a folder: a file in it, or a database that is made
// with the schema in it.
std::string catalog_url(const std::filesystem::path& place);
// Copies a folder, with its catalog, which nobody may have open.
void copy_place(const std::filesystem::path& from, const std::filesystem::path& to);
// Removes the catalog if it is not in the folder itself.
void remove_catalog(const std::filesystem::path& place);

// A temporary folder with a catalog.
class Place {
public:
    Place() = default;
    ~Place() { remove_catalog(folder_.path()); }
    Place(const Place&) = delete;
    Place& operator=(const Place&) = delete;

    std::string url() const { return catalog_url(folder_.path()); }
    const TemporaryFolder& folder() const { return folder_; }

private:
    TemporaryFolder folder_;
};

}  // namespace divemesh::storage
