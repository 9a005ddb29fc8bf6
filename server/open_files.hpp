#pragma once

namespace divemesh::server {

// Raises this process's soft limit of open files to what `num_connections` need, as far as the hard
// limit allows. Returns for how many connections the limit is enough, at most `num_connections`,
// and logs it if those are fewer.
int raise_open_files(int num_connections);

}  // namespace divemesh::server
