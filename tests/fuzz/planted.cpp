#include <cstdlib>

#include "tests/fuzz/input.hpp"

// A reader that believes the length which stands in front of the text.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    divemesh::fuzz::Input input(data, size);
    const auto length = input.choice(256);
    unsigned sum = 0;
    for (std::size_t i = 0; i < length; ++i)
        sum += static_cast<unsigned char>(input.rest().data()[i]);
    if (sum > 255 * length) std::abort();
    return 0;
}
