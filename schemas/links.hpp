#pragma once

namespace divemesh {

// What is done with symbolic links inside a folder. A link may lead to any file that the process
// can read, so they are followed only in folders that the user of this machine names.
enum class Links { LeaveOut, Follow };

}  // namespace divemesh
