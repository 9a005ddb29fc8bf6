#pragma once

#include <ceres/problem.h>
