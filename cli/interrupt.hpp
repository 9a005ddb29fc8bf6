#pragma once

namespace divemesh::cli {

// Makes Ctrl-C (or SIGTERM) ask the work to stop; a second one ends the program at once.
void catch_interrupts();

// For progress callbacks: throws Error{Cancelled} once a stop was requested.
void throw_if_interrupted();

}  // namespace divemesh::cli
