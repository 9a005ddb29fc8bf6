#pragma once

#include <vector>

#include "worker/simulator/jet.hpp"

namespace divemesh::simulator {

// A rest on a path.
struct Rest {
    double path_s = 0.0;      // where on the path, as the time at which it is there without rests
    double duration_s = 0.0;  // at complete rest
};

// The time on a path as a function of the time of the dive: it advances by one second per second,
// except that it comes to rest, with a smooth start and end of each rest.
class PathTime {
public:
    // How long the path takes to slow down to a rest and to speed up again.
    static constexpr double kRamp_s = 0.5;

    PathTime() : PathTime(std::vector<Rest>()) {}
    // Takes rests in their order on the path. One at 0 begins at rest. Throws
    // Error{InvalidArgument} if two of them are nearer to each other than the ramps between them.
    explicit PathTime(const std::vector<Rest>& rests);

    // Returns the time on the path and its derivatives at a time of the dive.
    Jet at(double t_s) const;
    // Returns the time of the dive at which the path ends if it ends at `path_s`: beyond all rests,
    // or at the end of the last one.
    double end_of(double path_s) const;

private:
    struct Segment {  // the rate runs from one value to the other by a smooth step
        double begin_s;
        double path_begin_s;
        double duration_s;
        double rate_begin;
        double rate_end;
    };

    void add(double duration_s, double rate_begin, double rate_end);
    void rest(const Rest& rest);

    std::vector<Segment> segments_;
    double end_s_ = 0.0;  // of the segments
    double path_end_s_ = 0.0;
};

}  // namespace divemesh::simulator
