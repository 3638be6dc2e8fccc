#pragma once

#include <string>

#include "brim/scene/document.h"
#include "brim/scene/errors.h"
#include "brim/scene/scene.h"

namespace brim {

/// Validates a document against a JSON Schema and fills in the schema's defaults, so that readers find every key with a
/// default. Supported: type, properties, required, additionalProperties, enum, const, minimum, maximum,
/// exclusiveMinimum, exclusiveMaximum, minLength, items, minItems, maxItems, oneOf, $ref to #/$defs, default, title,
/// description. Any other keyword in the schema is a programming error, as it would not be checked.
///
/// A oneOf first selects its branch and then validates only that, so that messages match the user's intent: by JSON
/// type; among objects by the property that is const in every branch ("kind"), or by the required key that is present.
///
/// All errors are collected in `errors`, one message each: file, line, JSON pointer, the value, what is allowed, and
/// for an unknown key the nearest known one. Values below a wrong one are left as given; values already in `errors`
/// (e.g. a failed expression) are skipped.
void validate(Document& document, const Json& schema, ErrorList& errors);

/// The same. @throws InputError, InputErrors  for errors
void validate(Document& document, const Json& schema);

/// The schema of scene files, parsed, including added branches.
const Json& scene_schema();

/// Adds a kind of body to the schema. @param branch  schema of an entry of "bodies" of that kind
/// @throws InputError  when the name is taken
void add_body_branch(const std::string& name, Json branch);

}  // namespace brim
