#pragma once

namespace divemesh::stats {

// Returns a / b, for shares and means; 0 unless b > 0.
template <typename A, typename B>
double ratio(A a, B b) {
    return b > 0 ? static_cast<double>(a) / static_cast<double>(b) : 0.0;
}

}  // namespace divemesh::stats
