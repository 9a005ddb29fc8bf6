#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "storage/blob_store.hpp"
#include "storage/catalog.hpp"

namespace divemesh::storage {

// Removes what attempts that did not succeed have left in the blob store, once they have been over
// for `age` (a worker that lost its lease may still be writing before that); at most `limit`
// attempts. How many there were.
int remove_leftovers(Catalog& catalog, BlobStore& blobs, std::chrono::milliseconds age, int limit);

// Events that happened longer ago: who resumes before them is told of the rest.
void forget_events(Catalog& catalog, std::chrono::milliseconds age);

}  // namespace divemesh::storage
