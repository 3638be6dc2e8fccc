#include "brim/io/child_reader.h"

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <ctime>

#include "brim/core/error.h"

namespace brim::child_reader_test {
namespace {

std::string message(ChildReader::Serve serve, int questions = 1) {
  ChildReader reader("a.vdb", std::move(serve));
  try {
    for (int q = 0; q < questions; ++q) reader.ask(q);
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(ChildReader, AnswersComeBackWholeAndInOrder) {
  int asked = 0;  // in the child alone
  ChildReader reader("a.vdb", [&](int question, ChildReader::Answer& answer) {
    answer.put(++asked);
    answer.put_text(std::string(static_cast<std::size_t>(question), 'x'));
    answer.put(std::vector<double>(1'000'000, 0.5).data(), 8'000'000);
  });
  for (const int question : {3, 0, 7}) {
    ChildReader::Received got = reader.ask(question);
    got.get<int>();
    EXPECT_EQ(got.get_text(), std::string(static_cast<std::size_t>(question), 'x'));
    std::vector<double> numbers(1'000'000);
    got.get(numbers.data(), 8'000'000);
    EXPECT_EQ(numbers, std::vector<double>(1'000'000, 0.5));
    EXPECT_EQ(got.left(), 0u);
    EXPECT_THROW(got.get<char>(), InputError);
  }
  EXPECT_EQ(asked, 0);
}

TEST(ChildReader, AnInterruptOfTheGroupIsForTheParentAlone) {
  for (const int signal : {SIGINT, SIGTERM}) {
    ChildReader reader("a.vdb", [&](int question, ChildReader::Answer& answer) {
      std::raise(signal);
      answer.put(question + 1);
    });
    EXPECT_EQ(reader.ask(6).get<int>(), 7) << signal;
  }
}

TEST(ChildReader, AnEmptyListIsAnAnswer) {
  ChildReader reader("a.obj", [](int, ChildReader::Answer& answer) { answer.put(nullptr, 0); });
  ChildReader::Received got = reader.ask(0);
  got.get(nullptr, 0);
  EXPECT_EQ(got.left(), 0u);
}

TEST(ChildReader, ListsLongerThanWhatCameAreRefused) {
  ChildReader reader("a.obj", [](int question, ChildReader::Answer& answer) {
    if (question == 0) return answer.put_list(std::vector<double>{1.0, 2.0});
    answer.put(std::size_t{1} << 62);
    answer.put(1.0);
  });
  EXPECT_EQ(reader.ask(0).get_list<double>(), (std::vector<double>{1.0, 2.0}));
  EXPECT_THROW(reader.ask(1).get_list<double>(), InputError);
  EXPECT_THROW(reader.ask(1).get_text(), InputError);
}

TEST(ChildReader, WhatTheReaderRefusesIsSaidAsItSaidIt) {
  EXPECT_EQ(message([](int, ChildReader::Answer&) { throw InputError("a.vdb: no grid"); }), "a.vdb: no grid");
  EXPECT_EQ(message([](int, ChildReader::Answer&) { throw std::runtime_error("odd"); }),
            "a.vdb: the file is damaged: odd");
}

TEST(ChildReader, WhateverEndsTheReaderIsOneInputError) {
  EXPECT_NE(message([](int, ChildReader::Answer&) { std::abort(); }).find("damaged"), std::string::npos);
  EXPECT_NE(message([](int, ChildReader::Answer&) { std::raise(SIGSEGV); }).find("damaged"), std::string::npos);
  EXPECT_NE(message([](int, ChildReader::Answer&) { std::_Exit(0); }).find("damaged"), std::string::npos);
  EXPECT_NE(message([](int, ChildReader::Answer&) { std::raise(SIGXCPU); }).find("processor time"), std::string::npos);
  EXPECT_NE(message(
                [](int q, ChildReader::Answer&) {
                  if (q == 2) std::abort();
                },
                3)
                .find("damaged"),
            std::string::npos);
}

TEST(ChildReader, TimeIsBounded) {
  ChildReader::set_base_seconds(1.0);
  const std::string why = message([](int, ChildReader::Answer&) {
    const volatile bool forever = true;
    while (forever) {
    }
  });
  ChildReader::set_base_seconds(60.0);
  // Whichever comes first: on a busy machine it is the time that the parent waits.
  EXPECT_TRUE(why.find("was not read in 1 s of processor time") != std::string::npos ||
              why.find("nothing was read of it in 2 s") != std::string::npos)
      << why;
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
TEST(ChildReader, TheFirstAnswerMayHaveLessTimeThanTheOthers) {
  const auto busy = [](double seconds) {
    const std::clock_t start = std::clock();
    while (static_cast<double>(std::clock() - start) < seconds * CLOCKS_PER_SEC) {
    }
  };
  ChildReader::Load load;
  load.opening = 1.0;
  const auto seconds_of = [&](int question) { return question == 0 ? 0.0 : 1.6; };
  ChildReader good("a.vdb", load, [&](int question, ChildReader::Answer&) { busy(seconds_of(question)); });
  good.ask(0);
  EXPECT_NO_THROW(good.ask(1));
  ChildReader late("a.vdb", load, [&](int, ChildReader::Answer&) { busy(60.0); });
  try {
    late.ask(0);
    FAIL();
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("in 1 s of processor time"), std::string::npos) << e.what();
  }
}

TEST(ChildReader, MemoryIsBounded) {
  const std::string why = message([](int, ChildReader::Answer& answer) {
    std::vector<char> much(std::size_t{3} << 30, 'x');
    answer.put(much[1]);
  });
  EXPECT_NE(why.find("memory"), std::string::npos) << why;
}
#endif

TEST(ChildReader, NoProcessIsLeftBehind) {
  message([](int, ChildReader::Answer&) { std::abort(); });
  message([](int, ChildReader::Answer&) {});
  EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), -1);
  EXPECT_EQ(errno, ECHILD);
}

}  // namespace
}  // namespace brim::child_reader_test
