#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "brim/scene/document.h"

namespace brim {

/// Value of a scene's parameter by name. @throws InputError  when it does not exist
using ValueOf = std::function<Json(const std::string& name)>;

/// Evaluates the text of an expression, which in a scene follows "=": a single name gives that parameter's value of any
/// type; else numbers, numeric parameters, + - * / ^, parentheses, pi, and
/// sqrt, exp, log, sin, cos, tan, abs, floor, ceil, round, min, max (angles in radians).
/// @return  the value; numbers are finite
/// @throws InputError  with the reason, without a place
/// Tests: tests/scene/expression_test.cpp
Json evaluate(std::string_view text, const ValueOf& value_of);

}  // namespace brim
