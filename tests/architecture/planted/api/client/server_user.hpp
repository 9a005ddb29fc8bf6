#pragma once

#include "api/routes.hpp"

namespace divemesh::api::client {}
