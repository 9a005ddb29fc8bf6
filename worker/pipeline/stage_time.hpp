#pragma once

#include <string>

namespace divemesh::pipeline {

// How long one stage of a run took.
struct StageTime {
    std::string stage;
    double wall_s = 0.0;
    double cpu_s = 0.0;   // of all threads
    bool reused = false;  // loaded: an earlier attempt or another job made it
};

// Measures the wall clock and the CPU time of the process from its construction on.
class Stopwatch {
public:
    Stopwatch();
    StageTime stop(std::string stage) const;

private:
    double wall_start_s_;
    double cpu_start_s_;
};

}  // namespace divemesh::pipeline
