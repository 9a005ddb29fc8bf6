#pragma once

#include <string>

namespace divemesh::pipeline {

// The time that one stage of a run took.
struct StageTime {
    std::string stage;
    double wall_s = 0.0;
    double cpu_s = 0.0;   // of all threads
    bool reused = false;  // loaded from an earlier attempt or another job
    bool is_evaluation = false;
};

// A clock of the process's wall-clock and CPU time since its construction.
class Stopwatch {
public:
    Stopwatch();
    StageTime stop(std::string stage) const;

private:
    double wall_start_s_;
    double cpu_start_s_;
};

}  // namespace divemesh::pipeline
