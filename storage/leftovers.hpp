#pragma once

#include <chrono>
#include <string>
#include <vector>

#include "storage/blob_store.hpp"
#include "storage/catalog.hpp"

namespace divemesh::storage {

// Removes what unsuccessful attempts have left in the blob store, of `limit` attempts at most;
// returns their number. Only attempts that ended at least `age` ago count, because a worker that
// lost its lease may still be writing.
int remove_leftovers(Catalog& catalog, BlobStore& blobs, std::chrono::milliseconds age, int limit);

// Forgets events that are older than `age`. A client that resumes before them is told of the rest.
void forget_events(Catalog& catalog, std::chrono::milliseconds age);

}  // namespace divemesh::storage
