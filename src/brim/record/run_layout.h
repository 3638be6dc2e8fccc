#pragma once

#include <array>

#include "brim/core/error.h"
#include "brim/record/h5.h"
#include "brim/world/measures.h"

/// Names inside run.h5, shared by writer and reader (docs/formats.md).
namespace brim::run_layout {

inline constexpr const char* kFormat = "brim-run";
inline constexpr int kVersion = 2;       ///< written
inline constexpr int kFirstVersion = 1;  ///< oldest readable
inline constexpr int kMostParts = 1 << 30;

/// One quantity of BodySample, recorded for all bodies in every frame.
struct MotionField {
  const char* path;
  int width;  ///< doubles per body
  void (*get)(const BodySample&, double*);
  void (*set)(BodySample&, const double*);
  bool late = false;  ///< runs of older versions lack it, and read as zeros
};

template <auto Member>
constexpr MotionField vector_field(const char* path, bool late = false) {
  return {path, 3,
          [](const BodySample& s, double* x) {
            for (int a = 0; a < 3; ++a) x[a] = (s.*Member)[a];
          },
          [](BodySample& s, const double* x) { s.*Member = Vec3(x[0], x[1], x[2]); }, late};
}
template <auto Member>
constexpr MotionField scalar_field(const char* path) {
  return {path, 1, [](const BodySample& s, double* x) { *x = s.*Member; },
          [](BodySample& s, const double* x) { s.*Member = *x; }};
}

inline constexpr std::array<MotionField, 7> kMotion = {
    vector_field<&BodySample::center>("/motion/center"),
    vector_field<&BodySample::velocity>("/motion/velocity"),
    vector_field<&BodySample::force>("/motion/force"),
    vector_field<&BodySample::impulse>("/motion/impulse", true),
    scalar_field<&BodySample::lowest>("/motion/lowest"),
    scalar_field<&BodySample::highest>("/motion/highest"),
    scalar_field<&BodySample::tilt_degrees>("/motion/tilt_degrees"),
};

inline const char* display_word(Display::Kind kind) {
  switch (kind) {
    case Display::Kind::Triangles:
      return "triangles";
    case Display::Kind::Lines:
      return "lines";
    case Display::Kind::Points:
      return "points";
  }
  return "points";
}

inline Display::Kind display_kind(const std::string& word, const std::string& file) {
  for (const Display::Kind kind : {Display::Kind::Triangles, Display::Kind::Lines, Display::Kind::Points})
    if (word == display_word(kind)) return kind;
  throw InputError(
      fmt::format("{}: display_kind is \"{}\"; it must be \"triangles\", \"lines\" or \"points\"", file, word));
}

}  // namespace brim::run_layout
