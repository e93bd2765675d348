// SPDX-License-Identifier: MIT
#include "formats/isolate.h"

#include <doctest/doctest.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <stdexcept>

#include "pipeline/error.h"
#include "tests/formats/scratch.h"

namespace skinlod {
namespace {

using Bytes = std::vector<std::byte>;

struct Outcome {
  int fault = 0;
  std::string message{};
  Bytes bytes{};
};

Outcome isolated(const std::function<Bytes()>& work, const Limits& limits = {}) {
  try {
    return {0, "", run_isolated("hero.fbx", limits, work)};
  } catch (const Error& e) {
    return {int(e.fault), e.what(), {}};
  }
}

bool says(const Outcome& outcome, const char* words) {
  return outcome.message.find(words) != std::string::npos;
}

int open_descriptors() {
  return int(std::distance(std::filesystem::directory_iterator("/proc/self/fd"), {}));
}

}  // namespace

TEST_SUITE("isolate") {
  TEST_CASE("the bytes of the work come back whole") {
    for (const size_t size : {0, 1, 1 << 16, 20'000'003}) {
      Bytes expected(size);
      for (size_t i = 0; i < size; ++i) expected[i] = std::byte(i * 31 >> 3);
      const Outcome outcome = isolated([&] { return expected; });
      CHECK(outcome.fault == 0);
      CHECK(outcome.bytes == expected);
    }
  }

  TEST_CASE("an error of ours arrives as it was thrown and any other is the input's fault") {
    const Outcome ours = isolated([]() -> Bytes { throw Error(Fault::Access, "hero.fbx: not for you"); });
    CHECK(ours.fault == int(Fault::Access));
    CHECK(ours.message == "hero.fbx: not for you");
    const Outcome other = isolated([]() -> Bytes { throw std::runtime_error("odd token"); });
    CHECK(other.fault == int(Fault::Input));
    CHECK(says(other, "hero.fbx: odd token: "));
  }

  TEST_CASE("a crash is bad input and the caller lives") {
    const Outcome abort = isolated([]() -> Bytes { std::abort(); });
    CHECK(abort.fault == int(Fault::Input));
    CHECK(says(abort, "hero.fbx: its reader gave up (aborted): "));
    const Outcome crash = isolated([]() -> Bytes { return ::raise(SIGSEGV), Bytes(); });
    CHECK(crash.fault == int(Fault::Input));
    CHECK(says(crash, "crashed (signal 11)"));
    const Outcome silent = isolated([]() -> Bytes { ::_exit(0); });
    CHECK(silent.fault == int(Fault::Input));
    CHECK(says(silent, "ended without an answer"));
    const Outcome unnamed = isolated([]() -> Bytes { throw 42; });
    CHECK(unnamed.fault == int(Fault::Input));
  }

  TEST_CASE("a kill from outside is a passing fault") {
    CHECK(isolated([]() -> Bytes { return ::raise(SIGKILL), Bytes(); }).fault == int(Fault::Temporary));
  }

  TEST_CASE("what computes or waits for ever is stopped") {
    const Outcome spins = isolated(
        []() -> Bytes {
          for (volatile bool on = true; on;) {
          }
          return {};
        },
        {.cpu_seconds = 1});
    CHECK(spins.fault == int(Fault::Input));
    CHECK(says(spins, "did not end in 1 s of CPU time"));
    const Outcome sleeps = isolated(
        []() -> Bytes {
          for (;;) ::pause();
        },
        {.wall_seconds = 1});
    CHECK(sleeps.fault == int(Fault::Input));
    CHECK(says(sleeps, "did not end in 1 s"));
  }

  TEST_CASE("what asks for too much memory is stopped") {
    // Far beyond the limit, and beyond what AddressSanitizer hands out where there is no limit.
    // Volatile, as clang 14 dies of computing the vector itself.
    volatile size_t size = size_t(1) << 45;
    const Outcome greedy = isolated([&] { return Bytes(size); });
    CHECK(greedy.fault == int(Fault::Input));
  }

  TEST_CASE("the work can print nothing") {
    const Scratch scratch;
    std::fflush(nullptr);
    const int out = ::dup(STDOUT_FILENO), err = ::dup(STDERR_FILENO);
    const int file = ::open(scratch.file("printed").c_str(), O_WRONLY | O_CREAT, 0666);
    ::dup2(file, STDOUT_FILENO), ::dup2(file, STDERR_FILENO), ::close(file);
    const Outcome loud = isolated([]() -> Bytes {
      std::puts("reading"), std::fputs("trouble\n", stderr), std::fflush(nullptr);
      return Bytes(3);
    });
    ::dup2(out, STDOUT_FILENO), ::dup2(err, STDERR_FILENO), ::close(out), ::close(err);
    CHECK(loud.bytes.size() == 3);
    CHECK(std::filesystem::exists(scratch.file("printed")));
    CHECK(text_of(scratch.file("printed")).empty());
  }

  TEST_CASE("no descriptor and no process stays behind") {
    const int before = open_descriptors();
    for (int i = 0; i < 5; ++i) {
      isolated([] { return Bytes(10); });
      isolated([]() -> Bytes { std::abort(); });
    }
    CHECK(open_descriptors() == before);
    CHECK(::waitpid(-1, nullptr, WNOHANG) == -1);
  }
}

}  // namespace skinlod
