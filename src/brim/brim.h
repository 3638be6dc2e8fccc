#pragma once

/// All that a program needs to build worlds, step them and read what happens (docs/cpp.md). Single kinds of bodies,
/// shapes and readers are in headers of their own, brim/body, brim/mesh and brim/io.

#include "brim/body/own/own_body.h"
#include "brim/body/own/own_body_check.h"
#include "brim/core/error.h"
#include "brim/core/parallel.h"
#include "brim/math/types.h"
#include "brim/raster/shape.h"
#include "brim/record/run_reader.h"
#include "brim/record/runner.h"
#include "brim/scene/own_kind.h"
#include "brim/scene/scene.h"
#include "brim/world/queries.h"
#include "brim/world/sense/sensors.h"
#include "brim/world/step_report.h"
#include "brim/world/world.h"
