// SPDX-License-Identifier: MIT
#include "formats/isolate.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <fstream>
#include <new>
#include <span>
#include <system_error>

#include "pipeline/error.h"

#if defined(__SANITIZE_ADDRESS__)
#define SKINLOD_ADDRESS_SANITIZER 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define SKINLOD_ADDRESS_SANITIZER 1
#endif
#endif

namespace skinlod {
namespace {

// A message begins with one byte: the fault of an Error whose text follows, or this, and the result follows.
constexpr std::byte kResult{0};

[[noreturn]] void fail_for_now(const std::string& subject, const char* what, int error) {
  throw Error(Fault::Temporary, subject + ": " + what + ": " + std::generic_category().message(error) +
                                    ": run again when the machine is less busy");
}

[[noreturn]] void give_up(const std::string& subject, const std::string& what) {
  throw Error(Fault::Input, subject + ": its reader " + what +
                                ": the file is damaged, or is not what its name says: export it again, or as "
                                "glTF");
}

[[noreturn]] void give_up(const std::string& subject, int signal, const Limits& limits) {
  switch (signal) {
    case SIGKILL:  // none of our limits: the kernel, when the machine's memory runs out
      throw Error(Fault::Temporary, subject +
                                        ": its reader was killed, as when memory runs out: run again "
                                        "when the machine is less busy");
    case SIGXCPU:
      give_up(subject, "did not end in " + std::to_string(limits.cpu_seconds) + " s of CPU time");
    case SIGABRT:
      give_up(subject, "gave up (aborted)");
    default:
      give_up(subject, "crashed (signal " + std::to_string(signal) + ")");
  }
}

std::uint64_t mapped_bytes() {
  std::uint64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  return pages * std::uint64_t(::sysconf(_SC_PAGESIZE));
}

/// `soft` brings a signal that tells which limit was passed, `hard` the end; neither is raised.
template <class Resource>
void limit(Resource resource, std::uint64_t soft, std::uint64_t hard) {
  rlimit now{};
  ::getrlimit(resource, &now);
  now.rlim_max = std::min<rlim_t>(now.rlim_max, hard);
  now.rlim_cur = std::min<rlim_t>(now.rlim_max, soft);
  ::setrlimit(resource, &now);
}

/// Cuts the child off from all it shares with its parent but the pipe, which becomes descriptor 3.
/// `mapped`: bytes of address space it starts with.
void confine(int pipe, const Limits& limits, [[maybe_unused]] std::uint64_t mapped) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  ::prctl(PR_SET_DUMPABLE, 0);
  for (const int signal :
       {SIGINT, SIGTERM, SIGHUP, SIGPIPE, SIGABRT, SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGXCPU}) {
    ::signal(signal, SIG_DFL);
  }
  ::dup2(pipe, 3);
  const int null = ::open("/dev/null", O_RDWR);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) ::dup2(null, stream);
  ::close_range(4, ~0U, 0);
  const auto seconds = std::uint64_t(limits.cpu_seconds);
  limit(RLIMIT_CORE, 0, 0);
  limit(RLIMIT_CPU, seconds, seconds + 1);
#ifndef SKINLOD_ADDRESS_SANITIZER
  limit(RLIMIT_AS, mapped + limits.memory_bytes, mapped + limits.memory_bytes);
#endif
}

bool send(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t n = ::write(3, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return false;
    bytes = bytes.subspan(size_t(n));
  }
  return true;
}

bool send(std::byte kind, std::span<const std::byte> bytes) { return send({&kind, 1}) && send(bytes); }

/// The child's whole life. It ends without destructors: what a broken file left behind may not bear them.
[[noreturn]] void live(const std::string& subject, const std::function<std::vector<std::byte>()>& work) {
  const auto report = [](Fault fault, const std::string& text) {
    return send(std::byte(fault), std::as_bytes(std::span(text)));
  };
  bool sent = false;
  try {
    sent = send(kResult, work());
  } catch (const Error& e) {
    sent = report(e.fault, e.what());
  } catch (const std::bad_alloc&) {
    sent = report(Fault::Input, subject +
                                    ": its reader asked for more memory than a file of this size needs: "
                                    "the file is damaged: export it again, or as glTF");
  } catch (const std::exception& e) {
    sent = report(Fault::Input, subject + ": " + e.what() + ": export it again, or as glTF");
  } catch (...) {  // it may not go on into the parent's code
  }
  ::_exit(sent ? 0 : 1);
}

/// All that arrives until the other end closes, or nothing when `deadline` comes first.
struct Received {
  std::vector<std::byte> bytes;
  bool in_time = true;
};
Received receive(int pipe, std::chrono::steady_clock::time_point deadline) {
  Received received;
  std::array<std::byte, 1 << 16> chunk;
  for (;;) {
    const auto left =
        std::chrono::ceil<std::chrono::milliseconds>(deadline - std::chrono::steady_clock::now()).count();
    pollfd ready{pipe, POLLIN, 0};
    if (left <= 0 || ::poll(&ready, 1, int(std::min<long>(left, 1 << 30))) == 0) return {{}, false};
    const ssize_t n = ready.revents ? ::read(pipe, chunk.data(), chunk.size()) : -1;
    if (n < 0 && (errno == EINTR || !ready.revents)) continue;
    if (n <= 0) return received;
    received.bytes.insert(received.bytes.end(), chunk.begin(), chunk.begin() + n);
  }
}

int wait_for(pid_t child) {
  int status = 0;
  while (::waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) return 0;  // somebody else has reaped it; the message says whether it ended well
  }
  return status;
}

}  // namespace

std::vector<std::byte> run_isolated(const std::string& subject, const Limits& limits,
                                    const std::function<std::vector<std::byte>()>& work) {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) fail_for_now(subject, "no pipe to its reader", errno);
  const std::uint64_t mapped = mapped_bytes();
  const pid_t child = ::fork();
  if (child < 0) {
    const int error = errno;
    ::close(ends[0]), ::close(ends[1]);
    fail_for_now(subject, "no process for its reader", error);
  }
  if (child == 0) {
    confine(ends[1], limits, mapped);
    live(subject, work);
  }
  ::close(ends[1]);
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(limits.wall_seconds);
  Received received;
  try {
    received = receive(ends[0], deadline);
  } catch (...) {
    ::kill(child, SIGKILL);
    ::close(ends[0]);
    wait_for(child);
    throw;
  }
  if (!received.in_time) ::kill(child, SIGKILL);
  ::close(ends[0]);
  const int status = wait_for(child);

  if (!received.in_time) give_up(subject, "did not end in " + std::to_string(limits.wall_seconds) + " s");
  if (WIFSIGNALED(status)) give_up(subject, WTERMSIG(status), limits);
  auto& bytes = received.bytes;
  if (bytes.empty() || WEXITSTATUS(status) != 0) give_up(subject, "ended without an answer");
  const std::byte kind = bytes.front();
  bytes.erase(bytes.begin());
  if (kind == kResult) return std::move(bytes);
  throw Error(Fault(kind), {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

}  // namespace skinlod
