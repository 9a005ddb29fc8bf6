#pragma once

#include <memory>
#include <new>
#include <utility>
#include <vector>

namespace divemesh::base {

// An allocator whose resize() leaves new elements uninitialised, if the type allows it. When
// several threads then write them, the page faults are spread over these threads too.
template <typename T>
class UninitialisedAllocator : public std::allocator<T> {
public:
    // The names are the standard's. NOLINTBEGIN(readability-identifier-naming)
    template <typename U>
    struct rebind {
        using other = UninitialisedAllocator<U>;
    };
    // NOLINTEND(readability-identifier-naming)
    UninitialisedAllocator() = default;
    template <typename U>
    explicit UninitialisedAllocator(const UninitialisedAllocator<U>&) noexcept {}

    template <typename U>
    void construct(U* place) {
        ::new (static_cast<void*>(place)) U;
    }
    template <typename U, typename... Arguments>
    void construct(U* place, Arguments&&... arguments) {
        ::new (static_cast<void*>(place)) U(std::forward<Arguments>(arguments)...);
    }
};

template <typename T>
using UninitialisedVector = std::vector<T, UninitialisedAllocator<T>>;

}  // namespace divemesh::base
