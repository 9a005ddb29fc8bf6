// The inner loops beside their counterparts in OpenCV, on one thread and the same images:
//   build/release/tests/bench/divemesh_kernels --benchmark_format=json
#include <benchmark/benchmark.h>
#include <opencv2/core/utility.hpp>

int main(int num_arguments, char** arguments) {
    cv::setNumThreads(1);
    benchmark::Initialize(&num_arguments, arguments);
    if (benchmark::ReportUnrecognizedArguments(num_arguments, arguments)) return 2;
    benchmark::RunSpecifiedBenchmarks();
    benchmark::Shutdown();
    return 0;
}
