#pragma once

#include <string>

#include "storage/blob_store.hpp"
#include "storage/catalog.hpp"

// The id of a data folder: a random word in the catalog and in the blob store. It shows that the
// two belong together, so nobody works with an unmounted disk or with another server's blobs.
namespace divemesh::storage {

// Returns whether the catalog has got its id, and with it its blob store.
bool has_data_id(Catalog& catalog);

// Returns the id that the catalog has; "" before it has one.
std::string data_id(Catalog& catalog);

// For the server, at its start: checks that the two belong together, after giving new data, and
// data of an earlier version, their id. Throws Error{Conflict} if they do not.
void claim_data(Catalog& catalog, BlobStore& blobs);

// For others, at any time: returns why the two do not belong together; "" if they do. Data of an
// earlier version, which have no id yet, do.
std::string data_mismatch(Catalog& catalog, BlobStore& blobs);

// Throws Error{Unavailable} if the two do not belong together.
void require_same_data(Catalog& catalog, BlobStore& blobs);

// Makes a catalog that was restored from a backup belong to the blob store.
void adopt_blobs(Catalog& catalog, BlobStore& blobs);

}  // namespace divemesh::storage
