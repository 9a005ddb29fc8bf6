#include "worker/boards/board.hpp"

#include "schemas/error.hpp"
#include "tests/fuzz/input.hpp"

// Fuzzes target files of calibration boards: what is read has a finite place for each corner.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    divemesh::fuzz::Input input(data, size);
    try {
        const auto board = divemesh::boards::parse_board(std::string(input.rest()), "board.yaml");
        if (board.num_corners() < 4 || board.num_corners() > 2500 ||
            !board.corner_m(board.num_corners() - 1).allFinite())
            __builtin_trap();
    } catch (const divemesh::Error&) {
    }
    return 0;
}
