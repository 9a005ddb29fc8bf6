#pragma once

namespace divemesh {

// Raises this process's limit of open files to the hard limit and ignores SIGPIPE, so that a peer
// that hangs up does not end the process.
void prepare_for_many_connections();

// Returns what `run` returns; 1 if it throws, with the message on stderr.
int run_or_say_why(int (*run)(int argc, char** argv), int argc, char** argv);

}  // namespace divemesh
