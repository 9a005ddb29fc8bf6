#pragma once

#include <cstdint>
#include <optional>

#include "worker/instructions.hpp"

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

// Byte operations (additions and minima in turn, on registers, none waiting for another) that one
// core does in a second with the vectors of an instruction set: no kernel can do more.
double byte_operations_per_s(worker::Instructions instructions);

}  // namespace divemesh::bench
