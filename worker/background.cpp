#include "worker/background.hpp"

#include <utility>

namespace divemesh::worker {

Background::~Background() {
    try {
        wait();
    } catch (...) {  // see the declaration
    }
}

void Background::run(std::function<void()> work) {
    wait();
    arena_.execute([&] { group_.run(std::move(work)); });
}

void Background::wait() {
    arena_.execute([&] { group_.wait(); });
}

}  // namespace divemesh::worker
