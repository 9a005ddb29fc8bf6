#pragma once

namespace divemesh::storage {

// Whether a catalog or blob store that is not there is created when it is opened. Only what owns
// the data may create it: to another program a missing one means a wrong path or an unmounted disk.
enum class Opening { CreateIfMissing, ExistingOnly };

}  // namespace divemesh::storage
