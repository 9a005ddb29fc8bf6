#pragma once

namespace divemesh::cli {

// Ctrl-C (or SIGTERM) asks the work to stop; a second one ends the program at once.
void catch_interrupts();

// For progress callbacks: throws Error{Cancelled} once it was asked for.
void throw_if_interrupted();

}  // namespace divemesh::cli
