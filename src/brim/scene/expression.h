#pragma once

#include <functional>
#include <string>
#include <string_view>

#include "brim/scene/document.h"

namespace brim {

/// Value of a scene's parameter by name. @throws InputError  when there is none
using ValueOf = std::function<Json(const std::string& name)>;

/// Computes the text of an expression, which in a scene stands after "=": a name alone is that parameter's value,
/// whatever it is; else numbers, names of numbers, + - * / ^, parentheses, pi, and
/// sqrt, exp, log, sin, cos, tan, abs, floor, ceil, round, min, max (angles in radians).
/// @return  the value; numbers are finite
/// @throws InputError  saying what is wrong, without a place
/// Tests: tests/scene/expression_test.cpp
Json evaluate(std::string_view text, const ValueOf& value_of);

}  // namespace brim
