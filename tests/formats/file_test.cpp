// SPDX-License-Identifier: MIT
#include "formats/file.h"

#include <doctest/doctest.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>

#include "pipeline/error.h"
#include "tests/formats/scratch.h"

namespace skinlod {
namespace {

std::span<const std::byte> bytes(std::string_view text) { return std::as_bytes(std::span(text)); }

std::string read_text(const std::string& path) {
  const std::vector<std::byte> read = read_file(path);
  return {reinterpret_cast<const char*>(read.data()), read.size()};
}

/// The fault of `action`, or 0 where it has none; its text goes to `message`.
template <class Action>
int fault_of(Action action, std::string* message = nullptr) {
  try {
    action();
  } catch (const Error& e) {
    if (message) *message = e.what();
    return int(e.fault);
  }
  return 0;
}

}  // namespace

TEST_SUITE("file") {
  TEST_CASE("what is written is read back and nothing else is left") {
    const Scratch scratch;
    for (const std::string& text : {std::string(), std::string("short"), std::string(300'001, 'x')}) {
      write_file(scratch.file("out"), bytes(text));
      CHECK(read_text(scratch.file("out")) == text);
    }
    CHECK(scratch.count() == 1);
  }

  TEST_CASE("a new file has the permissions that the user's mask leaves") {
    const Scratch scratch;
    const mode_t old = ::umask(027);
    write_file(scratch.file("out"), bytes("x"));
    ::umask(old);
    struct stat status {};
    REQUIRE(::stat(scratch.file("out").c_str(), &status) == 0);
    CHECK((status.st_mode & 0777) == 0640);
  }

  TEST_CASE("a link stays a link and what it points at is written") {
    const Scratch scratch;
    std::filesystem::create_directory(scratch.file("far"));
    std::filesystem::create_symlink("far/target", scratch.file("link"));
    for (const std::string& text : {std::string("new"), std::string("again")}) {  // dangling, then not
      write_file(scratch.file("link"), bytes(text));
      CHECK(std::filesystem::is_symlink(scratch.file("link")));
      CHECK(text_of(scratch.file("far/target")) == text);
    }
    std::filesystem::create_symlink("circle", scratch.file("circle"));
    CHECK(fault_of([&] { write_file(scratch.file("circle"), bytes("x")); }) == int(Fault::Access));
  }

  TEST_CASE("a folder or a path without a folder is refused in clear words") {
    const Scratch scratch;
    std::string message;
    CHECK(fault_of([&] { write_file(scratch.file(""), bytes("x")); }, &message) == int(Fault::Access));
    CHECK(message.find("is a folder") != std::string::npos);
    CHECK(fault_of([&] { write_file(scratch.file("no/such"), bytes("x")); }) == int(Fault::Access));
    CHECK(fault_of([&] { write_file("", bytes("x")); }) == int(Fault::Access));
    CHECK(fault_of([&] { read_file(scratch.file("")); }) == int(Fault::Access));
    CHECK(fault_of([&] { read_file(scratch.file("absent")); }, &message) == int(Fault::Access));
    CHECK(message.find("absent: cannot be opened: No such file") != std::string::npos);
    CHECK(scratch.count() == 0);
  }

  TEST_CASE("a full device is a passing fault") {
    std::string message;
    CHECK(fault_of([&] { write_file("/dev/full", bytes("x")); }, &message) == int(Fault::Temporary));
    CHECK(message.find("No space left") != std::string::npos);
    CHECK(std::filesystem::is_character_file("/dev/full"));  // not renamed over
  }

  TEST_CASE("on a full disk the old file stays and nothing is left behind") {
    const Scratch scratch;
    const std::string disk = scratch.file("disk");
    std::filesystem::create_directory(disk);
    if (::mount("skinlod", disk.c_str(), "tmpfs", 0, "size=64k") != 0) {
      MESSAGE("SKIPPED: no right to mount a small disk");
      return;
    }
    const std::string out = disk + "/out";
    write_file(out, bytes("old"));
    const std::string big(1 << 20, 'x');
    const int fault = fault_of([&] { write_file(out, bytes(big)); });
    const std::string after = text_of(out);
    const auto files = std::distance(std::filesystem::directory_iterator(disk), {});
    ::umount2(disk.c_str(), MNT_DETACH);
    CHECK(fault == int(Fault::Temporary));
    CHECK(after == "old");
    CHECK(files == 1);
  }

  TEST_CASE("a write that fails half way leaves the old file as it was") {
    const Scratch scratch;
    const std::string out = scratch.file("out", "old");
    rlimit old{};
    REQUIRE(::getrlimit(RLIMIT_FSIZE, &old) == 0);
    const auto handler = ::signal(SIGXFSZ, SIG_IGN);
    const rlimit small{100'000, old.rlim_max};
    REQUIRE(::setrlimit(RLIMIT_FSIZE, &small) == 0);
    const int fault = fault_of([&] { write_file(out, bytes(std::string(1 << 20, 'x'))); });
    ::setrlimit(RLIMIT_FSIZE, &old);
    ::signal(SIGXFSZ, handler);
    CHECK(fault == int(Fault::Access));
    CHECK(text_of(out) == "old");
    CHECK(scratch.count() == 1);
  }

  TEST_CASE("several files appear together or not at all") {
    const Scratch scratch;
    scratch.file("b", "old");
    {
      OutputSet outputs;
      outputs.add(scratch.file("a"), bytes("new a"));
      outputs.add(scratch.file("b"), bytes("new b"));
      CHECK(!std::filesystem::exists(scratch.file("a")));
      CHECK(fault_of([&] { outputs.add(scratch.file("no/c"), bytes("new c")); }) == int(Fault::Access));
    }
    CHECK(text_of(scratch.file("b")) == "old");
    CHECK(scratch.count() == 1);

    OutputSet outputs;
    outputs.add(scratch.file("a"), bytes("new a"));
    outputs.add(scratch.file("b"), bytes("new b"));
    outputs.commit();
    CHECK(text_of(scratch.file("a")) == "new a");
    CHECK(text_of(scratch.file("b")) == "new b");
    CHECK(scratch.count() == 2);
  }

  TEST_CASE("a file that cannot be replaced brings those before it back") {
    for (const char* stubborn : {"first", "middle", "last"}) {
      CAPTURE(stubborn);
      const Scratch scratch;
      OutputSet outputs;
      for (const char* name : {"first", "middle", "last"}) {
        outputs.add(scratch.file(name), bytes("new"));
        if (name != std::string("middle")) scratch.file(name, "old");
      }
      std::filesystem::remove(scratch.file(stubborn));
      std::filesystem::create_directory(scratch.file(stubborn));
      CHECK(fault_of([&] { outputs.commit(); }) == int(Fault::Access));
      for (const char* name : {"first", "last"}) {
        if (name != std::string(stubborn)) CHECK(text_of(scratch.file(name)) == "old");
      }
      CHECK(std::filesystem::is_directory(scratch.file(stubborn)));
      CHECK(std::filesystem::exists(scratch.file("middle")) == (stubborn == std::string("middle")));
    }
  }

  TEST_CASE("what went back leaves nothing else behind") {
    const Scratch scratch;
    const std::string a = scratch.file("a", "old"), b = scratch.file("b");
    {
      OutputSet outputs;
      for (const std::string& path : {a, b}) outputs.add(path, bytes("new"));
      std::filesystem::create_directory(b);
      CHECK(fault_of([&] { outputs.commit(); }) == int(Fault::Access));
    }
    CHECK(text_of(a) == "old");
    CHECK(scratch.count() == 2);
  }

  TEST_CASE("a killed run leaves no half-written file") {
    const Scratch scratch;
    scratch.file("out", "old");
    const pid_t child = ::fork();
    if (child == 0) {
      ::signal(SIGTERM, [](int) {
        remove_unfinished_files();
        ::_exit(7);
      });
      OutputSet outputs;
      outputs.add(scratch.file("out"), bytes("new"));
      outputs.add(scratch.file("other"), bytes("new"));
      if (scratch.count() == 3) ::raise(SIGTERM);
      ::_exit(0);
    }
    int status = 0;
    REQUIRE(::waitpid(child, &status, 0) == child);
    CHECK(WEXITSTATUS(status) == 7);
    CHECK(text_of(scratch.file("out")) == "old");
    CHECK(scratch.count() == 1);
  }
}

}  // namespace skinlod
