// SPDX-License-Identifier: MIT
#include <doctest/doctest.h>
#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <nlohmann/json.hpp>
#include <thread>

#include "formats/file.h"
#include "formats/gltf.h"
#include "tests/tools/harness.h"

/// The program as it is run: exit codes, standard streams, signals. The rest is tested in-process.
namespace skinlod {
namespace {

using Names = std::set<std::string>;
using namespace std::chrono_literals;

// A running skinlod. Its standard error goes to a file; its standard output too, or to a pipe with little
// room in it.
class Process {
 public:
  Process(const TemporaryFolder& streams, const std::vector<std::string>& args, const std::string& out = "")
      : err_(streams / "err") {
    out_ = out.empty() ? streams / "out" : out;
    int pipe_ends[2] = {-1, -1};
    if (out == "pipe") {
      if (pipe(pipe_ends) != 0) throw std::runtime_error("no pipe");
      fcntl(pipe_ends[1], F_SETPIPE_SZ, 4096);
      fcntl(pipe_ends[0], F_SETFD, FD_CLOEXEC);
      pipe_ = pipe_ends[0];
    }
    id_ = fork();
    if (id_ == 0) {
      for (const int signal : {SIGINT, SIGQUIT, SIGTERM, SIGPIPE, SIGHUP, SIGXCPU})
        std::signal(signal, SIG_DFL);
      const rlimit no_core{0, 0};
      setrlimit(RLIMIT_CORE, &no_core);
      dup2(pipe_ >= 0 ? pipe_ends[1] : open(out_.c_str(), O_CREAT | O_WRONLY | O_TRUNC, 0600), STDOUT_FILENO);
      dup2(open(err_.c_str(), O_CREAT | O_WRONLY | O_TRUNC, 0600), STDERR_FILENO);
      std::vector<char*> words = {const_cast<char*>(SKINLOD_BINARY)};
      for (const std::string& word : args) words.push_back(const_cast<char*>(word.c_str()));
      words.push_back(nullptr);
      execv(SKINLOD_BINARY, words.data());
      _exit(127);
    }
    if (pipe_ >= 0) close(pipe_ends[1]);
  }
  ~Process() {
    if (!ended_) kill(id_, SIGKILL), wait();
    close_pipe();
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  void send(int signal) const { kill(id_, signal); }
  void close_pipe() {
    if (pipe_ >= 0) close(pipe_);
    pipe_ = -1;
  }
  bool running() {
    if (!ended_) ended_ = waitpid(id_, &status_, WNOHANG) == id_;
    return !ended_;
  }
  /// The exit code, or minus the signal that ended it.
  int wait() {
    if (!ended_) waitpid(id_, &status_, 0), ended_ = true;
    return WIFEXITED(status_) ? WEXITSTATUS(status_) : -WTERMSIG(status_);
  }
  std::string out() const { return contents(out_); }
  std::string err() const { return contents(err_); }

 private:
  std::string out_, err_;
  pid_t id_ = -1;
  int pipe_ = -1, status_ = 0;
  bool ended_ = false;
};

Outcome real(const std::vector<std::string>& args) {
  const TemporaryFolder streams;
  Process process(streams, args);
  const int code = process.wait();
  return {code, process.out(), process.err()};
}

// A character as a file, the only thing the real program takes.
void put_character(const std::string& path, const Character& tube = test_tube()) {
  write_file(path, write_glb(tube, tube.surface));
}

// Waits until half-written files stand beside the outputs: everything is cooked, and the pipe is full.
bool wait_for_unfinished_files(Process& process, const TemporaryFolder& folder, const Names& before) {
  for (int i = 0; i < 6000 && process.running(); ++i) {
    Names now = folder.names();
    for (const std::string& name : before) now.erase(name);
    if (std::any_of(now.begin(), now.end(), [](const std::string& name) { return !name.ends_with("/"); }))
      return true;
    std::this_thread::sleep_for(10ms);
  }
  return false;
}

}  // namespace

TEST_SUITE("real_binary") {
  TEST_CASE("each kind of end has its exit code and its message") {
    const TemporaryFolder folder;
    put_character(folder / "hero.glb");
    put(folder / "empty.glb", "");

    CHECK(real({"--version"}).out.starts_with("skinlod "));
    const Outcome cooked = real({"cook", folder / "hero.glb", "-o", folder / "hero.slod"});
    CAPTURE(cooked.err);
    CHECK(cooked.code == 0);
    CHECK(cooked.out.find("\nLOD4 ") != std::string::npos);
    CHECK(cooked.err.find('\x1b') == std::string::npos);  // no progress into a file

    const std::string before = contents(folder / "hero.slod");
    const auto fails = [&](std::vector<std::string> args) {
      const Outcome outcome = real(args);
      CAPTURE(outcome.err);
      CHECK(outcome.err.starts_with("skinlod: "));
      CHECK(contents(folder / "hero.slod") == before);
      return outcome.code;
    };
    const std::string out = folder / "hero.slod";
    CHECK(fails({"cook", folder / "hero.glb", "-o", out, "--lods", "0%"}) == 2);
    CHECK(fails({"cook", folder / "hero.glb", "-o", out, "--otput", out}) == 2);
    CHECK(fails({"cook", folder / "empty.glb", "-o", out}) == 3);
    CHECK(fails({"cook", folder / "missing.glb", "-o", out}) == 4);
    CHECK(fails({"cook", folder / "hero.glb", "-o", folder / "missing/hero.slod"}) == 4);
    CHECK(real({"cook", folder / "hero.glb", "-o", folder / "few.slod", "--lods", "1"}).code == 1);
    CHECK(folder.names() == Names{"hero.glb", "empty.glb", "hero.slod", "few.slod"});
  }
  TEST_CASE("a pipe carries the character in and the file out") {
    const TemporaryFolder folder;
    put_character(folder / "hero.glb");
    REQUIRE(real({"cook", folder / "hero.glb", "-o", folder / "hero.slod", "--report", folder / "r1"}).code ==
            0);
    const std::string command = std::string("cat '") + (folder / "hero.glb") +
                                "' | '" SKINLOD_BINARY "' cook - -o - --report '" + (folder / "r2") +
                                "' > '" + (folder / "piped.slod") + "'";
    CHECK(std::system(command.c_str()) == 0);
    // The file bears the name of what it was made of, and a pipe has none; all else is the same.
    const auto levels = [&](const char* name) {
      return nlohmann::json::parse(contents(folder / name))["levels"];
    };
    CHECK(levels("r1") == levels("r2"));
    CHECK(contents(folder / "r2").find("/proc") == std::string::npos);

    const std::string broken = "echo nonsense | '" SKINLOD_BINARY "' cook - -o '" + (folder / "x.slod") +
                               "' 2> '" + (folder / "err") + "'";
    CHECK(WEXITSTATUS(std::system(broken.c_str())) == 3);
    CHECK(contents(folder / "err").starts_with("skinlod: standard input: "));
    const std::string inspect =
        "'" SKINLOD_BINARY "' inspect - < '" + (folder / "hero.slod") + "' > '" + (folder / "shown") + "'";
    CHECK(std::system(inspect.c_str()) == 0);
    CHECK(contents(folder / "shown").starts_with("-: .slod version 1, "));
  }
  TEST_CASE("a signal leaves nothing half-written and is what the program dies of") {
    for (const int signal : {SIGINT, SIGQUIT, SIGTERM, SIGHUP, SIGPIPE, SIGXCPU}) {
      CAPTURE(signal);
      const TemporaryFolder folder, streams;
      put_character(folder / "hero.glb", bending_tube(24, 60, 3));
      put(folder / "r.json", "before");
      const Names before = folder.names();
      Process process(
          streams, {"cook", folder / "hero.glb", "-o", "-", "--no-compress", "--report", folder / "r.json"},
          "pipe");
      REQUIRE(wait_for_unfinished_files(process, folder, before));
      if (signal == SIGPIPE) {
        process.close_pipe();
      } else {
        process.send(signal);
      }
      CHECK(process.wait() == -signal);
      CHECK(folder.names() == before);
      CHECK(contents(folder / "r.json") == "before");
    }
  }
  TEST_CASE("a signal in the middle of the work leaves nothing behind") {
    const TemporaryFolder folder, streams;
    put_character(folder / "hero.glb", bending_tube(64, 200, 3));
    put(folder / "hero.slod", "before");
    Process process(streams,
                    {"cook", folder / "hero.glb", "-o", folder / "hero.slod", "--gltf", folder / "lods"});
    std::this_thread::sleep_for(100ms);
    process.send(SIGINT);
    const int end = process.wait();
    if (end == 0) MESSAGE("the cook was faster than the signal");
    CHECK((end == -SIGINT || end == 0));
    if (end != 0) CHECK(contents(folder / "hero.slod") == "before");
    if (end != 0) CHECK(folder.names() == Names{"hero.glb", "hero.slod"});
  }
  TEST_CASE("a full device is exit 75 and the other outputs stay as they were") {
    const TemporaryFolder folder, streams;
    put_character(folder / "hero.glb");
    put(folder / "r.json", "before");
    const std::vector<std::string> cook = {"cook", folder / "hero.glb", "--report", folder / "r.json", "-o"};
    for (const char* out : {"-", "/dev/full"}) {
      std::vector<std::string> args = cook;
      args.push_back(out);
      Process process(streams, args, "/dev/full");
      CHECK(process.wait() == 75);
      CAPTURE(process.err());
      CHECK(process.err().find("No space left on device") != std::string::npos);
      CHECK(folder.names() == Names{"hero.glb", "r.json"});
      CHECK(contents(folder / "r.json") == "before");
    }
    CHECK(Process(streams, {"formats"}, "/dev/full").wait() == 75);
  }
  TEST_CASE("a result that cannot be told leaves the old file whole") {
    const TemporaryFolder folder, streams;
    put_character(folder / "hero.glb");
    put(folder / "hero.slod", "before");
    const std::vector<std::string> table = {"cook", folder / "hero.glb", "-o", folder / "hero.slod"};
    std::vector<std::string> json = table;
    json.push_back("--json");
    for (const auto& args : {table, json}) {
      CHECK(Process(streams, args, "/dev/full").wait() == 75);
      CHECK(contents(folder / "hero.slod") == "before");
      CHECK(folder.names() == Names{"hero.glb", "hero.slod"});
    }
    const std::string closed = "'" SKINLOD_BINARY "' cook '" + (folder / "hero.glb") + "' -o '" +
                               (folder / "hero.slod") + "' >&- 2>'" + (streams / "err") + "'";
    CHECK(WEXITSTATUS(std::system(closed.c_str())) == 4);
    CHECK(contents(streams / "err").starts_with("skinlod: standard output: "));
    CHECK(contents(folder / "hero.slod") == "before");
    CHECK(folder.names() == Names{"hero.glb", "hero.slod"});
  }
  TEST_CASE("a file that may not grow so far is exit 4 and leaves the old file whole") {
    const TemporaryFolder folder, streams;
    put_character(folder / "hero.glb", bending_tube(24, 100, 3));
    put(folder / "hero.slod", "before");
    const std::string limited = "ulimit -f 8; '" SKINLOD_BINARY "' cook '" + (folder / "hero.glb") +
                                "' -o '" + (folder / "hero.slod") + "' -q 2>'" + (streams / "err") + "'";
    const int status = std::system(limited.c_str());
    CHECK(WIFEXITED(status));
    CHECK(WEXITSTATUS(status) == 4);
    CHECK(contents(streams / "err").find("File too large") != std::string::npos);
    CHECK(contents(folder / "hero.slod") == "before");
    CHECK(folder.names() == Names{"hero.glb", "hero.slod"});
  }
  TEST_CASE("a full disk is exit 75 and leaves the old file whole") {
    const TemporaryFolder folder;
    put_character(folder / "hero.glb", bending_tube(24, 100, 3));
    std::filesystem::create_directory(folder / "disk");
    // A disk of two pages in a namespace of its own: it goes with the shell.
    put(folder / "script", "mount -t tmpfs -o size=8k tmpfs '" + (folder / "disk") + "' || exit 77\ncd '" +
                               (folder / "disk") + "'\necho before > hero.slod\n'" SKINLOD_BINARY "' cook '" +
                               (folder / "hero.glb") + "' -o hero.slod -q 2> '" + (folder / "err") +
                               "'\necho $? $(ls -A) $(cat hero.slod) > '" + (folder / "result") + "'\n");
    const int status = std::system(("unshare -Urm sh '" + (folder / "script") + "' 2>/dev/null").c_str());
    if (status != 0) {
      MESSAGE("SKIPPED: this machine does not let us mount a small disk");
      return;
    }
    CHECK(contents(folder / "result") == "75 hero.slod before\n");
    CHECK(contents(folder / "err").find("No space left on device") != std::string::npos);
  }
}

}  // namespace skinlod
