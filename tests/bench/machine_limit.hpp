#pragma once

#include <cstdint>
#include <optional>

#include "schemas/file_descriptor.hpp"
#include "worker/base/instructions.hpp"

namespace divemesh::bench {

// Counts the instructions that this thread retires, by the processor's counter.
class InstructionCounter {
public:
    InstructionCounter();

    void start();
    // Returns the count since start(); nullopt if kernel or hypervisor deny access to the counter.
    std::optional<std::uint64_t> stop();

private:
    FileDescriptor file_;
};

// Returns the CPU time of this thread, s.
double thread_cpu_s();

// Returns the number of byte operations per second of one core with the vectors of an instruction
// set, measured by independent additions and minima on registers. It is the upper limit of any
// kernel.
double byte_operations_per_s(base::Instructions instructions);

// Returns the number of bytes that one core reads from memory per second in sequence: the upper
// limit of any pass over an image.
double bytes_read_per_s();

}  // namespace divemesh::bench
