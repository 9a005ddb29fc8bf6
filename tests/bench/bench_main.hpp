#pragma once

namespace divemesh {

// Lets this process have as many open files as the machine allows, and outlive peers that hang up.
void prepare_for_many_connections();

// What `run` returns; 1 and what it threw on stderr otherwise.
int run_or_say_why(int (*run)(int argc, char** argv), int argc, char** argv);

}  // namespace divemesh
