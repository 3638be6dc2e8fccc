#pragma once

namespace brim {

struct Document;
class ErrorList;

/// Collects in `errors` the keys of deformable volumes that a rigid one gives ("young_modulus", "law", ...). To be
/// called before presets and defaults fill in such keys, which rigid volumes do not read. Tests:
/// tests/scene/image_volume_test.cpp
void refuse_idle_keys(const Document& document, ErrorList& errors);

}  // namespace brim
