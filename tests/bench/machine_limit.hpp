#pragma once

#include <cstdint>
#include <optional>

#include "worker/base/instructions.hpp"

namespace divemesh::bench {

// Instructions that this thread retires, from the processor's own counter; nothing where the kernel
// or the hypervisor does not let it be read.
class InstructionCounter {
public:
    InstructionCounter();
    ~InstructionCounter();
    InstructionCounter(const InstructionCounter&) = delete;
    InstructionCounter& operator=(const InstructionCounter&) = delete;

    void start();
    std::optional<std::uint64_t> stop();

private:
    int file_;
};

// CPU time of this thread.
double thread_cpu_s();

// Byte operations (additions and minima in turn, on registers, none waiting for another) that one
// core does in a second with the vectors of an instruction set: no kernel can do more.
double byte_operations_per_s(base::Instructions instructions);

// Bytes that one core reads in a second from memory, one after the other: no pass over a map can be
// faster.
double bytes_read_per_s();

}  // namespace divemesh::bench
