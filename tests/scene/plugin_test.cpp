#include "brim/scene/plugin.h"

#include <dlfcn.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "brim/core/error.h"

/// What is no plugin; those that are one need a program that shows them brim (tests/apps/cli_test.cpp).
namespace brim::plugin_test {
namespace {

std::string message(const std::string& path) {
  try {
    load_plugin(path);
    return "no error";
  } catch (const InputError& e) {
    return e.what();
  }
}

TEST(Plugin, ALibraryThatAddsNoKindIsRefusedEachTime) {
  Dl_info libc{};
  ASSERT_NE(::dladdr(reinterpret_cast<const void*>(&std::getenv), &libc), 0);
  const std::string path = libc.dli_fname;
  for (int i = 0; i < 2; ++i) EXPECT_EQ(message(path).find(path + ": is no plugin of brim"), 0u) << message(path);
}

TEST(Plugin, WhatIsNoLibraryIsRefusedByItsName) {
  EXPECT_EQ(message("none.so").find("none.so: ./none.so: cannot open"), 0u) << message("none.so");
  EXPECT_EQ(message("/dev/null").find("/dev/null: "), 0u) << message("/dev/null");
}

}  // namespace
}  // namespace brim::plugin_test
