#pragma once

#include "brim/core/simd.h"  // the former name of that header
