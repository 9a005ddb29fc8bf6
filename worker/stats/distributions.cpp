#include "worker/stats/distributions.hpp"

#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/normal.hpp>
#include <boost/math/distributions/students_t.hpp>

namespace divemesh::stats {
namespace {

namespace policies = boost::math::policies;

// Returns NaN for invalid arguments, as the functions of <cmath> do.
using Quiet = policies::policy<policies::domain_error<policies::ignore_error>,
                               policies::overflow_error<policies::ignore_error>,
                               policies::evaluation_error<policies::ignore_error>>;

}  // namespace

double normal_quantile(double share) {
    return boost::math::quantile(boost::math::normal_distribution<double, Quiet>(), share);
}

double student_t_quantile(double share, double degrees_of_freedom) {
    return boost::math::quantile(
        boost::math::students_t_distribution<double, Quiet>(degrees_of_freedom), share);
}

double chi_square_quantile(double share, double degrees_of_freedom) {
    return boost::math::quantile(
        boost::math::chi_squared_distribution<double, Quiet>(degrees_of_freedom), share);
}

}  // namespace divemesh::stats
