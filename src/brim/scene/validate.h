#pragma once

#include <string>

#include "brim/scene/document.h"
#include "brim/scene/errors.h"
#include "brim/scene/scene.h"

namespace brim {

/// Holds a document against a JSON Schema and fills in the schema's defaults, so that readers find every key that has
/// one. Understood: type, properties, required, additionalProperties, enum, const,
/// minimum, maximum, exclusiveMinimum, exclusiveMaximum, minLength, items, minItems, maxItems, oneOf, $ref to #/$defs,
/// default, title, description. Any other keyword in the schema is a programming error: it would promise what is not
/// checked.
///
/// A oneOf picks its branch first and then checks only that, so that the message speaks of what the user meant:
/// by the JSON type; among objects by the property that is const in every branch ("kind"), or by the required key that
/// is present.
///
/// All that is wrong is collected in `errors`, one message each: file, line, JSON pointer, the value, what is allowed,
/// and for an unknown key the nearest known one. What lies below a wrong value is left as it was given, and a value
/// that `errors` holds already (a formula that could not be computed) is not looked at.
void validate(Document& document, const Json& schema, ErrorList& errors);

/// The same. @throws InputError, InputErrors  when something is wrong
void validate(Document& document, const Json& schema);

/// The schema of scene files, parsed, with the branches that were added.
const Json& scene_schema();

/// Adds a kind of body to the schema. @param branch  schema of an entry of "bodies" of that kind
/// @throws InputError  when the name is taken
void add_body_branch(const std::string& name, Json branch);

}  // namespace brim
