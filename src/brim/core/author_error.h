#pragma once

#include <exception>
#include <new>

#include "brim/core/error.h"

namespace brim {

/// f(), the code of an author of bodies. Errors that brim itself raises pass; of others refuse(e) tells whose they are.
/// @param refuse  called with the std::exception; must throw
template <class F, class Refuse>
auto call_author(const F& f, const Refuse& refuse) {
  try {
    return f();
  } catch (const InputError&) {
    throw;
  } catch (const ProgrammingError&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& e) {
    refuse(e);
    throw;
  }
}

}  // namespace brim
